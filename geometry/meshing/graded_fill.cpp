#include "geometry/meshing/graded_fill.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "geometry/common/error.hpp"
#include "geometry/meshing/surface_process.hpp"

namespace forefeel {

// ---- lines

namespace {

constexpr double sharp_cosine = 0.6427876;  // of 50 degrees between normals

Link link_of(NodeIndex a, NodeIndex b) {
  return {std::min(a, b), std::max(a, b)};
}

struct Side {
  Link link;
  std::size_t triangle;
};

std::vector<Side> sides_of(const Surface& surface) {
  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({link_of(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]), t});
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return a.link != b.link ? a.link < b.link : a.triangle < b.triangle;
  });
  return sides;
}

// Edges whose two triangles differ in the sense of `apart`.
template <class Apart>
std::vector<Link> edges_between(const Surface& surface, const Apart& apart) {
  std::vector<Link> result;
  const std::vector<Side> sides = sides_of(surface);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].link == sides[i + 1].link && apart(sides[i].triangle, sides[i + 1].triangle))
      result.push_back(sides[i].link);
  return result;
}

// A polygon of three to five nodes, cut into triangles around its node `from`.
void add_fan(std::vector<Triangle>& into, const std::vector<NodeIndex>& polygon, std::size_t from) {
  const std::size_t n = polygon.size();
  for (std::size_t k = 1; k + 1 < n; ++k)
    into.push_back({polygon[from], polygon[(from + k) % n], polygon[(from + k + 1) % n]});
}

}  // namespace

double rim_level(const Box& box, const LowEnd& low_end) {
  const auto k = static_cast<Eigen::Index>(low_end.axis);
  return box.low[k] + low_end.share * (box.high[k] - box.low[k]);
}

void cut_at(Surface& surface, Axis axis, double level) {
  const auto k = static_cast<Eigen::Index>(axis);
  std::map<Link, NodeIndex> made;
  const auto height = [&](NodeIndex node) { return surface.nodes[node][k] - level; };
  const auto crossing = [&](NodeIndex a, NodeIndex b) {
    const Link link = link_of(a, b);
    const auto [at, fresh] = made.emplace(link, static_cast<NodeIndex>(surface.nodes.size()));
    if (fresh) {
      const Vec3 from = surface.nodes[link[0]], to = surface.nodes[link[1]];
      Vec3 node = from + height(link[0]) / (height(link[0]) - height(link[1])) * (to - from);
      node[k] = level;
      surface.nodes.push_back(node);
    }
    return at->second;
  };
  std::vector<Triangle> triangles;
  for (const Triangle& t : surface.triangles) {
    std::vector<NodeIndex> low, high;  // the polygons on both sides, in the triangle's sense
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex a = t[i], b = t[(i + 1) % 3];
      if (height(a) <= 0) low.push_back(a);
      if (height(a) >= 0) high.push_back(a);
      if ((height(a) < 0 && height(b) > 0) || (height(a) > 0 && height(b) < 0)) {
        const NodeIndex node = crossing(a, b);
        low.push_back(node), high.push_back(node);
      }
    }
    const auto above = [&](NodeIndex node) { return height(node) > 0; };
    const auto below = [&](NodeIndex node) { return height(node) < 0; };
    if (std::ranges::none_of(t, above) || std::ranges::none_of(t, below))
      triangles.push_back(t);
    else
      add_fan(triangles, low, 0), add_fan(triangles, high, 0);
  }
  surface.triangles = std::move(triangles);
}

std::vector<Link> borders(const Surface& surface, std::span<const int> marks) {
  return edges_between(surface, [&](std::size_t s, std::size_t t) { return marks[s] != marks[t]; });
}

std::vector<int> marks_below(const Surface& surface, Axis axis, double level) {
  const auto k = static_cast<Eigen::Index>(axis);
  std::vector<int> marks;
  for (const Triangle& t : surface.triangles)
    marks.push_back(std::ranges::all_of(t, [&](NodeIndex node) { return surface.nodes[node][k] <= level; }));
  return marks;
}

std::vector<Link> sharp_edges(const Surface& surface) {
  std::vector<Vec3> normals;
  for (const auto& [a, b, c] : surface.triangles)
    normals.push_back(
        (surface.nodes[b] - surface.nodes[a]).cross(surface.nodes[c] - surface.nodes[a]).normalized());
  return edges_between(
      surface, [&](std::size_t s, std::size_t t) { return normals[s].dot(normals[t]) < sharp_cosine; });
}

std::vector<NodeIndex> corners_of(const Surface& surface, std::span<const Link> lines, double turn_cosine) {
  std::map<NodeIndex, std::vector<NodeIndex>> neighbours;
  for (const auto& [a, b] : lines) neighbours[a].push_back(b), neighbours[b].push_back(a);
  std::vector<NodeIndex> corners;
  for (const auto& [node, ends] : neighbours) {
    const auto towards = [&surface, &from = node, &to = ends](std::size_t i) -> Vec3 {
      return (surface.nodes[to[i]] - surface.nodes[from]).normalized();
    };
    if (ends.size() != 2 || -towards(0).dot(towards(1)) < turn_cosine) corners.push_back(node);
  }
  return corners;
}

std::function<Vec3(const Vec3&)> nearest_on_lines(const Surface& surface, std::span<const Link> lines) {
  const auto segments = std::make_shared<std::vector<std::array<Vec3, 2>>>();
  for (const auto& [a, b] : lines) segments->push_back({surface.nodes[a], surface.nodes[b]});
  return [segments](const Vec3& p) {
    Vec3 best = p;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : *segments) {
      const Vec3 along = b - a;
      const double squared = along.squaredNorm();
      const double t = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
      const Vec3 point = t < 1 ? Vec3(a + t * along) : b;
      const double distance = (point - p).squaredNorm();
      if (distance < least) least = distance, best = point;
    }
    return best;
  };
}

// ---- skins

namespace {

constexpr double smooth_turn = 0.5;  // lines may turn by 60 degrees at a node that is no corner

NodeIndex nearest_node(const Surface& surface, const Vec3& point) {
  NodeIndex best = 0;
  for (NodeIndex i = 1; i < surface.nodes.size(); ++i)
    if ((surface.nodes[i] - point).squaredNorm() < (surface.nodes[best] - point).squaredNorm()) best = i;
  return best;
}

void add_corners(GradedInput& input, std::span<const Link> lines, double turn_cosine) {
  const std::vector<NodeIndex> found = corners_of(input.start, lines, turn_cosine);
  input.corners.insert(input.corners.end(), found.begin(), found.end());
}

void pin(GradedInput& input, const Vec3& point) {
  const NodeIndex node = nearest_node(input.start, point);
  input.start.nodes[node] = point;
  input.corners.push_back(node);
}

// turn_cosine: as of corners_of().
void settle(GradedInput& input, double turn_cosine) {
  std::erase_if(input.sharp, [&](const Link& link) { return std::ranges::binary_search(input.rim, link); });
  std::vector<Link> all = input.sharp;
  all.insert(all.end(), input.rim.begin(), input.rim.end());
  add_corners(input, all, turn_cosine);
  // Where a line changes its kind it has an end.
  for (const Link& link : input.sharp)
    for (const NodeIndex node : link)
      if (std::ranges::any_of(input.rim,
                              [&](const Link& other) { return std::ranges::count(other, node) > 0; }))
        input.corners.push_back(node);
  std::ranges::sort(input.corners);
  input.corners.erase(std::unique(input.corners.begin(), input.corners.end()), input.corners.end());
}

// Triangles of the wanted sizes on the surface.
double wanted_triangles(const Surface& surface, const SizeField& size) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 &p = surface.nodes[a], &q = surface.nodes[b], &r = surface.nodes[c];
    const double edge = size.at((p + q + r) / 3);
    sum += (q - p).cross(r - p).norm() / 2 / (std::sqrt(3.0) / 4 * edge * edge);
  }
  return sum;
}

// The ends of the body along an axis. With them as nodes, the mesh has the extent of the surface.
std::vector<Vec3> ends_along(const Surface& surface, Axis axis) {
  const auto k = static_cast<Eigen::Index>(axis);
  const auto [low, high] =
      std::ranges::minmax_element(surface.nodes, [&](const Vec3& a, const Vec3& b) { return a[k] < b[k]; });
  return {*low, *high};
}

}  // namespace

GradedSurface graded_skin(const Surface& closed, const SkinOptions& options, const SizeField& size) {
  GradedInput input{.start = closed, .size = size};
  // Far finer surfaces lose their noise first, as where they are remeshed evenly. Borders of marks would be lost.
  const double far_finer =
      static_cast<double>(closed.triangles.size()) / (6 * wanted_triangles(closed, size));
  if (options.marks.empty() && far_finer > 1) input.start = decimated(closed, 1 / far_finer);
  const auto nearest = nearest_on(closed);
  input.onto = [nearest](const Vec3& p) { return nearest(p).point; };
  for (const Vec3& point : options.pins) pin(input, point);
  if (!options.marks.empty()) {
    input.rim = borders(closed, options.marks);
    input.onto_rim = nearest_on_lines(closed, input.rim);
  }
  if (options.rim) {
    for (const Vec3& end : ends_along(closed, options.rim->axis)) pin(input, end);
    const Axis axis = options.rim->axis;
    const double level = rim_level(bounding_box(closed), *options.rim);
    Surface exact = closed;
    cut_at(exact, axis, level);
    input.onto_rim = nearest_on_lines(exact, borders(exact, marks_below(exact, axis, level)));
    cut_at(input.start, axis, level);
    input.rim = borders(input.start, marks_below(input.start, axis, level));
  }
  if (options.keep_sharp) input.sharp = sharp_edges(input.start);
  input.onto_sharp = nearest_on_lines(input.start, input.sharp);
  // Borders of marks are exact: a mesh is seldom made coarser than the one that they come from.
  settle(input, options.marks.empty() ? smooth_turn : 0.999);
  return graded_surface(input);
}

GradedSurface graded_skin(const SmoothSkin& body, const SizeField& size) {
  GradedInput input{.start = body.start, .onto = body.onto, .size = size};
  for (const Vec3& point : body.pins) pin(input, point);
  cut_at(input.start, body.axis, body.level);
  input.rim = borders(input.start, marks_below(input.start, body.axis, body.level));
  const auto k = static_cast<Eigen::Index>(body.axis);
  input.onto_rim = [&body, k](Vec3 p) {
    p[k] = body.level;
    return body.onto_cut(p, body.axis);
  };
  for (const Link& link : input.rim)
    for (const NodeIndex node : link) input.start.nodes[node] = input.onto_rim(input.start.nodes[node]);
  settle(input, smooth_turn);
  return graded_surface(input);
}

std::optional<GradedSurface> without_intersections(GradedSurface given) {
  if (!intersects_itself(given.surface)) return given;
  RepairReport report;
  GradedSurface mended{repair_surface(given.surface, report), {}, given.onto};
  if (report.wrapped) return std::nullopt;
  const auto place = [](const Vec3& p) { return std::array{p.x(), p.y(), p.z()}; };
  std::set<std::array<double, 3>> held;
  for (std::size_t i = 0; i < given.held.size(); ++i)
    if (given.held[i]) held.insert(place(given.surface.nodes[i]));
  for (const Vec3& node : mended.surface.nodes) mended.held.push_back(held.contains(place(node)));
  return mended;
}

// ---- the fill

std::vector<int> marks_on(const Surface& repaired, const Surface& input, std::span<const int> marks) {
  std::vector<int> result;
  if (marks.empty()) return result;
  const auto nearest = nearest_on(input);
  for (const auto& [a, b, c] : repaired.triangles)
    result.push_back(
        marks[nearest((repaired.nodes[a] + repaired.nodes[b] + repaired.nodes[c]) / 3).triangle]);
  return result;
}

CountedFill fill_graded(const GradedSurface& skin, const SizeField& size, std::size_t elements, double share,
                        TetFillOptions options) {
  options.size = [size](const Vec3& point) { return size.at(point); };
  options.held = skin.held;
  options.onto = skin.onto;
  return fill_to_count(skin.surface, elements, share, std::move(options));
}

}  // namespace forefeel
