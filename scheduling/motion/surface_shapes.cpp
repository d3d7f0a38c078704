#include "scheduling/motion/surface_shapes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

constexpr double clearance = 0.010;  // height over the surface outside [m]
constexpr double sampled = 0.002;    // way over the surface between points of a path [m]

struct Hand {
  const TouchSurface& surface;
  double depth;  // [m]

  Vec3 pressed(const SurfacePoint& s, double share = 1) const { return s.at - share * depth * s.normal; }
  Vec3 above(const SurfacePoint& s) const { return s.at + clearance * s.normal; }

  // Points of a walk of this length, the first left out; fewer where the clamp ends it. way: of length 1, turned.
  std::vector<SurfacePoint> walk(const SurfacePoint& from, Vec3& way, double length) const {
    std::vector<SurfacePoint> points;
    SurfacePoint here = from;
    for (double left = length; left > 1e-9; left -= sampled) {
      Vec3 step = std::min(sampled, left) * way;
      const double wanted = step.norm();
      const SurfacePoint next = surface.walked(here, step);
      if (!(step.norm() > 0.5 * wanted)) break;
      way = step.normalized();
      points.push_back(here = next);
    }
    return points;
  }

  bool clear(const Vec3& from, const Vec3& to) const {
    const int parts = std::max(2, static_cast<int>(std::ceil((to - from).norm() / 0.003)));
    for (int i = 0; i <= parts; ++i)
      if (surface.inside(from + (to - from) * (static_cast<double>(i) / parts))) return false;
    return true;
  }

  // From one point outside to another, straight or around the body on a sphere.
  void travel(const Vec3& from, const Vec3& to, std::vector<Vec3>& points) const {
    if (!clear(from, to)) {
      const Box box = surface.box();
      const Vec3 centre = 0.5 * (box.low + box.high);
      const double radius = 0.5 * box.size().norm() + clearance;
      const Vec3 a = (from - centre).normalized(), b = (to - centre).normalized();
      const Vec3 axis = a.cross(b).norm() > 1e-6 ? Vec3(a.cross(b).normalized()) : a.unitOrthogonal();
      const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
      const int parts = std::max(1, static_cast<int>(std::ceil(angle / 0.15)));
      for (int i = 0; i <= parts; ++i)
        points.push_back(centre + radius * (Eigen::AngleAxisd(angle * i / parts, axis) * a));
    }
    points.push_back(to);
  }
};

// A direction of length 1 across the normal.
Vec3 across(const SurfacePoint& s, double turn) {
  const Vec3 e = s.normal.unitOrthogonal();
  return std::cos(turn) * e + std::sin(turn) * s.normal.cross(e);
}

PathShape line(const Hand& hand, const SurfacePoint& start, double turn) {
  constexpr double length = 0.15;
  Vec3 way = across(start, turn), back = -way;
  // Half of it behind the start, so that a start near the clamp does not shorten it.
  const std::vector<SurfacePoint> behind = hand.walk(start, back, length / 2);
  const std::vector<SurfacePoint> ahead =
      hand.walk(start, way, length - sampled * static_cast<double>(behind.size()));
  std::vector<SurfacePoint> points(behind.rbegin(), behind.rend());
  points.push_back(start);
  points.insert(points.end(), ahead.begin(), ahead.end());
  PathShape shape{{hand.above(points.front())}, {}};
  for (const SurfacePoint& s : points) shape.loop.push_back(hand.pressed(s));
  for (std::size_t i = points.size() - 1; i-- > 1;) shape.loop.push_back(hand.pressed(points[i]));
  return shape;
}

PathShape raster(const Hand& hand, const SurfacePoint& centre, double turn) {
  constexpr int rows = 9;
  constexpr double apart = 0.008, half = 0.040;
  PathShape shape;
  std::vector<Vec3> points;
  for (int row = 0; row < rows; ++row) {
    const double offset = apart * (row - rows / 2);
    Vec3 side = across(centre, turn + (offset < 0 ? -0.5 : 0.5) * std::numbers::pi);
    const std::vector<SurfacePoint> to_row = hand.walk(centre, side, std::abs(offset));
    if (sampled * static_cast<double>(to_row.size()) < std::abs(offset) - sampled)
      continue;  // over the clamp
    const SurfacePoint middle = to_row.empty() ? centre : to_row.back();
    // Along the row: across the way that led to it.
    Vec3 along = middle.normal.cross(side) * (offset < 0 ? 1 : -1), back = -along;
    std::vector<SurfacePoint> line = hand.walk(middle, back, half);
    std::ranges::reverse(line);
    line.push_back(middle);
    const std::vector<SurfacePoint> ahead = hand.walk(middle, along, half);
    line.insert(line.end(), ahead.begin(), ahead.end());
    if (row % 2 == 1) std::ranges::reverse(line);
    if (points.empty()) shape.lead = {hand.above(line.front())};
    for (const SurfacePoint& s : line) points.push_back(hand.pressed(s));
  }
  shape.loop = points;
  for (std::size_t i = points.size() - 1; i-- > 1;) shape.loop.push_back(points[i]);
  return shape;
}

PathShape palpation(const Hand& hand, std::vector<SurfacePoint> places) {
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {  // each next one is the nearest
    const auto distance = [&](const SurfacePoint& p) { return (p.at - places[i].at).squaredNorm(); };
    const auto from = places.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    std::iter_swap(from, std::ranges::min_element(from, places.end(), {}, distance));
  }
  PathShape shape{{hand.above(places.front())}, {}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i > 0) hand.travel(hand.above(places[i - 1]), hand.above(places[i]), shape.loop);
    if (i == 0) shape.loop.push_back(hand.above(places[i]));
    shape.loop.push_back(hand.pressed(places[i]));
    shape.loop.push_back(hand.above(places[i]));
  }
  hand.travel(hand.above(places.back()), hand.above(places.front()), shape.loop);
  return shape;
}

PathShape tour(const Hand& hand, const SurfacePoint& start, std::uint64_t seed) {
  constexpr int slides = 8;
  constexpr double length = 0.040;
  PathShape shape{{hand.above(start)}, {hand.above(start)}};
  SurfacePoint here = start;
  double before = 1;
  for (std::uint64_t i = 0; i < slides; ++i) {
    Vec3 way = across(here, random::two_pi * random::uniform(random::mix(seed, 2 * i)));
    const double after = 0.3 + 0.7 * random::uniform(random::mix(seed, 2 * i + 1));
    const std::vector<SurfacePoint> points = hand.walk(here, way, length);
    if (i == 0) shape.loop.push_back(hand.pressed(here));
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double t = static_cast<double>(k + 1) / static_cast<double>(points.size());
      shape.loop.push_back(hand.pressed(points[k], before + t * (after - before)));
    }
    if (points.empty()) continue;
    here = points.back(), before = after;
  }
  shape.loop.push_back(hand.above(here));
  hand.travel(hand.above(here), hand.above(start), shape.loop);
  return shape;
}

InputError no_path_on_surface(PathName path) {
  return InputError(
      {.key = "device", .value = fmt::format("path:{}", name(path))},
      "is a path around one place, expected line, raster, palpation or tour with contact.anywhere");
}

}  // namespace

void check_on_surface(const DeviceSpec& device) {
  const auto* hand = std::get_if<HandMotion>(&device.motion());
  const PathMotion* motion = hand ? &hand->target : std::get_if<PathMotion>(&device.motion());
  if (motion &&
      std::ranges::none_of(std::array{PathName::line, PathName::raster, PathName::palpation, PathName::tour},
                           [&](PathName path) { return path == motion->path; }))
    throw no_path_on_surface(motion->path);
}

PathShape surface_shape(const PathMotion& motion, const TouchSurface& surface, std::uint64_t seed) {
  constexpr std::size_t palpated = 12;
  const Hand hand{surface, motion.depth.value_or(0.6 * surface.depth())};
  const bool many = motion.path == PathName::palpation;
  const std::vector<SurfacePoint> places = surface.points(motion.where, many ? palpated : 1, seed);
  const double turn = random::two_pi * random::uniform(random::mix(seed, 77));
  switch (motion.path) {
    case PathName::line:
      return line(hand, places.front(), turn);
    case PathName::raster:
      return raster(hand, places.front(), turn);
    case PathName::palpation:
      return palpation(hand, places);
    case PathName::tour:
      return tour(hand, places.front(), seed);
    default:
      throw no_path_on_surface(motion.path);
  }
}

}  // namespace forefeel
