#include "solver/jet/smooth_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr double flat_angle = 1e-9;                    // [rad]
constexpr double widest_fan = 1.9 * std::numbers::pi;  // of an open fan
constexpr double longest_fade = std::numbers::pi / 3;  // of what takes P to a kept edge

// g and its slope: 1 to 0 over [0, 1], without slope at both ends.
double step_down(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return 1 - t * t * (3 - 2 * t);
}
double step_slope(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return -6 * t * (1 - t);
}

double angle_of(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Matrix<double, 3, 1> squares(double x, double y) {
  return {x * x, x * y, y * y};
}

}  // namespace

// Walks from facet to facet around a node, and knows which edges are kept.
struct SmoothSurface::Walker {
  std::span<const SmoothFacet> facets;
  const std::vector<Facet>& shapes;
  std::map<std::uint32_t, std::vector<std::uint32_t>> kept;  // by node: where its kept edges lead

  struct Sector {
    std::int32_t facet = -1;
    std::size_t corner = 0;
  };

  bool is_kept(std::int32_t facet, std::size_t side) const {
    const std::int32_t beside = facets[static_cast<std::size_t>(facet)].beside[side];
    return beside < 0 || angle_of(shapes[static_cast<std::size_t>(facet)].normal,
                                  shapes[static_cast<std::size_t>(beside)].normal) > feature_angle;
  }
  std::uint32_t node(const Sector& at, std::size_t ahead = 0) const {
    return facets[static_cast<std::size_t>(at.facet)].corners[(at.corner + ahead) % 3];
  }
  // Across the edge before (clockwise) or behind it.
  std::optional<Sector> beside(const Sector& at, bool clockwise) const {
    const std::size_t side = clockwise ? at.corner : (at.corner + 2) % 3;
    if (is_kept(at.facet, side)) return {};
    Sector next{facets[static_cast<std::size_t>(at.facet)].beside[side], 0};
    while (node(next) != node(at)) ++next.corner;
    return next;
  }
  std::vector<Sector> around(const Sector& from, bool& closed) const {
    Sector first = from;
    closed = false;
    while (const auto before = beside(first, true)) {
      first = *before;
      closed = first.facet == from.facet;
      if (closed) break;
    }
    std::vector<Sector> sectors{first};
    while (const auto next = beside(sectors.back(), false)) {
      if (next->facet == first.facet) break;
      sectors.push_back(*next);
    }
    return sectors;
  }
};

SmoothSurface::SmoothSurface(std::span<const Vec3> nodes, std::span<const SmoothFacet> facets) {
  for (const SmoothFacet& given : facets) {
    Facet& facet = facets_.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      facet.corner[i] = nodes[given.corners[i]];
      const Vec3 way = nodes[given.corners[(i + 1) % 3]] - facet.corner[i];
      facet.length[i] = way.norm(), facet.edge[i] = way.normalized();
    }
    facet.normal = (facet.corner[1] - facet.corner[0]).cross(facet.corner[2] - facet.corner[0]).normalized();
  }
  find_fans(facets);
  // Nodes around which y is no surface near the facets keep them.
  for (bool any = true; any;) {
    any = false;
    farthest_ = 0;
    std::vector<char> faceted(nodes.size(), 0);
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      double lift = 0;
      if (facets_[f].flat || is_sound(facets_[f], lift)) {
        farthest_ = std::max(farthest_, lift);
        continue;
      }
      for (const std::uint32_t node : facets[f].corners) faceted[node] = 1;
    }
    for (std::size_t f = 0; f < facets_.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i)
        if (faceted[facets[f].corners[i]] != 0 && facets_[f].corners[i].fan >= 0)
          facets_[f].corners[i].fan = -1, any = true;
  }
  std::vector<char> faceted(nodes.size(), 0);
  for (std::size_t f = 0; f < facets_.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i)
      if (facets_[f].corners[i].fan < 0) faceted[facets[f].corners[i]] = 1;
  faceted_nodes_ = static_cast<std::size_t>(std::ranges::count(faceted, 1));
}

void SmoothSurface::find_fans(std::span<const SmoothFacet> facets) {
  Walker walker{facets, facets_, {}};
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t side = 0; side < 3; ++side) {
      facets_[f].kept[side] = walker.is_kept(static_cast<std::int32_t>(f), side);
      if (!facets_[f].kept[side]) continue;
      const std::uint32_t a = facets[f].corners[side], b = facets[f].corners[(side + 1) % 3];
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        if (auto& list = walker.kept[from]; std::ranges::find(list, to) == list.end()) list.push_back(to);
      if (facets[f].beside[side] < 0 || facets[f].beside[side] > static_cast<std::int32_t>(f)) ++kept_edges_;
    }
  std::map<std::uint32_t, Vec3> place;
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) place[facets[f].corners[i]] = facets_[f].corner[i];

  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      if (facets_[f].corners[i].fan >= 0) continue;
      bool closed = false;
      const std::vector<Walker::Sector> sectors = walker.around({static_cast<std::int32_t>(f), i}, closed);
      const std::uint32_t node = facets[f].corners[i];
      Fan& fan = fans_.emplace_back();
      fan.node = place[node];
      std::vector<std::uint32_t> spokes;
      std::vector<double> angles;
      bool flat = true;
      for (const Walker::Sector& sector : sectors) {
        const Facet& facet = facets_[static_cast<std::size_t>(sector.facet)];
        spokes.push_back(walker.node(sector, 1)), angles.push_back(fan.angle);
        fan.angle += angle_of(facet.edge[sector.corner], -facet.edge[(sector.corner + 2) % 3]);
        flat = flat && angle_of(facet.normal, facets_[f].normal) < flat_angle;
      }
      const std::uint32_t last = walker.node(sectors.back(), 2);
      closed = closed || (sectors.size() > 2 && last == spokes.front());  // a kept edge that ends here
      if (closed) {
        fan.scale = 2 * std::numbers::pi / fan.angle;
      } else {
        spokes.push_back(last), angles.push_back(fan.angle);
        fan.scale = std::min(1.0, widest_fan / fan.angle);
      }
      flat = flat && (!closed || std::abs(fan.scale - 1) < flat_angle);
      fan.angle *= fan.scale;
      for (double& angle : angles) angle *= fan.scale;
      std::vector<Vec3> ends;
      for (const std::uint32_t spoke : spokes) ends.push_back(place[spoke]);
      fit(fan, ends, angles);
      for (std::size_t k = 0; k < sectors.size(); ++k)
        facets_[static_cast<std::size_t>(sectors[k].facet)].corners[sectors[k].corner] = {
            static_cast<std::int32_t>(fans_.size() - 1), angles[k]};
      if (!closed) {
        fan.open = true;
        const std::vector<std::uint32_t>& kept = walker.kept[node];
        for (const std::size_t end : {std::size_t{0}, std::size_t{1}}) {
          const std::uint32_t to = end == 0 ? spokes.front() : spokes.back();
          const Vec3 way = place[to] - fan.node;
          Vec3 linear = way.normalized(), square = Vec3::Zero();
          if (kept.size() == 2) {  // a smooth curve through three nodes, unless it turns a corner
            const Vec3 back = place[kept[kept[0] == to ? 1 : 0]] - fan.node;
            const double a = way.norm(), b = back.norm();
            if (angle_of(way, -back) < feature_angle && angle_of(way, -back) > flat_angle) {
              square = (way / a + back / b) / (a + b);
              linear = way / a - a * square;
              flat = false;
            }
          }
          const double angle = end == 0 ? 0 : fan.angle, x = std::cos(angle), y = std::sin(angle);
          fan.kept_linear[end] = linear - fan.linear * Eigen::Vector2d(x, y);
          fan.kept_square[end] = square - fan.square * squares(x, y);
        }
      }
      fan.flat = flat;
    }
  for (Facet& facet : facets_)
    facet.flat = std::ranges::all_of(facet.corners, [&](const Corner& corner) {
      return fans_[static_cast<std::size_t>(corner.fan)].flat;
    });
}

// Linear and square terms by least squares, of the neighbours weighted by 1 / length^2. Where there are too few of them
// the square terms are the least that fit.
void SmoothSurface::fit(Fan& fan, std::span<const Vec3> ends, std::span<const double> angles) const {
  const auto rows = static_cast<Eigen::Index>(ends.size());
  double mean = 0;
  for (const Vec3& end : ends) mean += (end - fan.node).norm() / static_cast<double>(rows);
  constexpr double ridge = 1e-3;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows + 3, 5), b = Eigen::MatrixXd::Zero(rows + 3, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Vec3 way = ends[static_cast<std::size_t>(i)] - fan.node;
    const double length = way.norm(), angle = angles[static_cast<std::size_t>(i)];
    const double x = std::cos(angle), y = std::sin(angle), square = length / mean;
    a.row(i) << x, y, square * x * x, square * x * y, square * y * y;
    b.row(i) = way.transpose() / length;
  }
  for (Eigen::Index i = 0; i < 3; ++i) a(rows + i, 2 + i) = ridge;
  const Eigen::MatrixXd terms = least_squares(a, b);
  fan.linear = terms.topRows(2).transpose();
  fan.square = terms.bottomRows(3).transpose() / mean;
}

// Adds P of a corner, and its derivative by the place on the facet.
void SmoothSurface::add_corner(const Facet& facet, std::size_t i, const Vec3& s, Vec3& value,
                               Mat3& by) const {
  if (facet.corners[i].fan < 0) {
    value = s, by = Mat3::Identity();
    return;
  }
  const Fan& fan = fans_[static_cast<std::size_t>(facet.corners[i].fan)];
  const Vec3 d = s - facet.corner[i], &e = facet.edge[i], m = facet.normal.cross(e);
  const double along = e.dot(d), aside = m.dot(d), length = std::hypot(along, aside);
  const double turn = length > 0 ? std::atan2(aside, along) : 0;
  const double angle = facet.corners[i].start + fan.scale * turn, c = std::cos(angle), sn = std::sin(angle);
  const double x = length * c, y = length * sn;
  const Vec3 out = length > 0 ? Vec3((along * e + aside * m) / length) : e, round = facet.normal.cross(out);
  const Vec3 by_x = fan.linear.col(0) + 2 * x * fan.square.col(0) + y * fan.square.col(1),
             by_y = fan.linear.col(1) + x * fan.square.col(1) + 2 * y * fan.square.col(2);
  value = fan.node + fan.linear * Eigen::Vector2d(x, y) + fan.square * squares(x, y);
  Vec3 by_out = c * by_x + sn * by_y, by_round = fan.scale * (c * by_y - sn * by_x);
  if (fan.open) {
    const double wide = std::min(0.5 * fan.angle, longest_fade);
    for (const std::size_t end : {std::size_t{0}, std::size_t{1}}) {
      const double t = (end == 0 ? angle : fan.angle - angle) / wide;
      const Vec3 &a = fan.kept_linear[end], &b = fan.kept_square[end];
      value += step_down(t) * length * (a + length * b);
      by_out += step_down(t) * (a + 2 * length * b);
      by_round += step_slope(t) * (end == 0 ? 1 : -1) / wide * fan.scale * (a + length * b);
    }
  }
  by = by_out * out.transpose() + by_round * round.transpose();
}

SmoothSpot SmoothSurface::blended(const Facet& facet, const Vec3& share) const {
  const Vec3 s = share[0] * facet.corner[0] + share[1] * facet.corner[1] + share[2] * facet.corner[2];
  // The weights of the edges, and of the corners on each edge.
  std::array<double, 3> distance{}, square{}, g{}, g_by{};
  std::array<Vec3, 3> inward, square_by;
  for (std::size_t i = 0; i < 3; ++i) {
    inward[i] = facet.normal.cross(facet.edge[i]);
    distance[i] = inward[i].dot(s - facet.corner[i]);
    const double tau = facet.edge[i].dot(s - facet.corner[i]) / facet.length[i];
    g[i] = step_down(tau), g_by[i] = step_slope(tau) / facet.length[i];
  }
  double sum = 0;
  Vec3 sum_by = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double product = distance[j] * distance[k];
    square[i] = product * product;
    square_by[i] = 2 * product * (distance[k] * inward[j] + distance[j] * inward[k]);
    sum += square[i], sum_by += square_by[i];
  }
  std::array<double, 3> weight{};
  std::array<Vec3, 3> weight_by{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  if (!(sum > 0)) {  // at a corner
    Eigen::Index at = 0;
    share.maxCoeff(&at);
    weight[static_cast<std::size_t>(at)] = 1;
  } else {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double part = square[i] / sum;
      const Vec3 part_by = (square_by[i] - part * sum_by) / sum, along = part * g_by[i] * facet.edge[i];
      weight[i] += part * g[i], weight[j] += part * (1 - g[i]);
      weight_by[i] += g[i] * part_by + along, weight_by[j] += (1 - g[i]) * part_by - along;
    }
  }
  SmoothSpot spot;
  spot.at = s, spot.by.setZero();
  for (std::size_t i = 0; i < 3; ++i) {
    if (weight[i] == 0 && weight_by[i].isZero(0)) continue;
    Vec3 value;
    Mat3 by;
    add_corner(facet, i, s, value, by);
    spot.at += weight[i] * (value - s);
    spot.by += (value - s) * weight_by[i].transpose() + weight[i] * by;
  }
  const Vec3 across = facet.normal.cross(facet.edge[0]);
  spot.normal = (spot.by * facet.edge[0]).cross(spot.by * across).normalized();
  spot.by += (spot.normal - spot.by * facet.normal) * facet.normal.transpose();
  return spot;
}

SmoothSpot SmoothSurface::at(std::int32_t number, const Vec3& share) const {
  const Facet& facet = facets_[static_cast<std::size_t>(number)];
  if (!facet.flat) return blended(facet, share);
  return {share[0] * facet.corner[0] + share[1] * facet.corner[1] + share[2] * facet.corner[2], facet.normal,
          Mat3::Identity()};
}

// lift: how far y is from the facet.
bool SmoothSurface::is_sound(const Facet& facet, double& lift) const {
  constexpr int parts = 6;
  constexpr double least_cosine = 0.3, least_area = 0.1, longest = 3;
  const double longest_edge = std::ranges::max(facet.length);
  for (int i = 0; i <= parts; ++i)
    for (int j = 0; i + j <= parts; ++j) {
      const SmoothSpot spot = blended(facet, Vec3(parts - i - j, i, j) / parts);
      const Vec3 s = (facet.corner[0] * (parts - i - j) + facet.corner[1] * i + facet.corner[2] * j) / parts;
      lift = std::max(lift, std::abs(facet.normal.dot(spot.at - s)));
      if (!((spot.at - s).norm() < most_lift * longest_edge) ||
          !(spot.normal.dot(facet.normal) > least_cosine) ||
          !(spot.by.col(0).cross(spot.by.col(1)).dot(spot.by.col(2)) > least_area) ||
          !(spot.by.colwise().norm().maxCoeff() < longest))
        return false;
    }
  return true;
}

}  // namespace forefeel
