// Sides of gaps: the directions in which known regions lie (region_summary.hpp).

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "geometry/common/union_find.hpp"
#include "geometry/coverage/region_summary.hpp"

namespace forefeel {
namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr std::size_t most_bridges = 1000;  // gaps whose sides are found, largest first

// Directions in one cell of this side are merged, because clustering up to 2000 single directions would be slow.
constexpr double grain = 0.04;

struct Ray {
  Vec3 unit;        // mean of the cell
  double distance;  // of its nearest state [m]
  std::size_t states;
};

std::vector<Ray> gather_rays(std::span<const Vec3> offsets) {
  std::map<std::array<int, 3>, Ray> cells;
  for (const Vec3& d : offsets) {
    const double length = d.norm();
    if (!(length > 0)) continue;
    const Vec3 u = d / length;
    const auto cell = [&](int axis) { return static_cast<int>(std::floor(u[axis] / grain)); };
    auto [entry, fresh] = cells.try_emplace({cell(0), cell(1), cell(2)}, Ray{Vec3::Zero(), length, 0});
    entry->second.unit += u;
    entry->second.distance = std::min(entry->second.distance, length);
    ++entry->second.states;
  }
  std::vector<Ray> rays;
  for (auto& [cell, ray] : cells) rays.push_back({ray.unit.normalized(), ray.distance, ray.states});
  return rays;
}

}  // namespace

double bridge_link_deg(double sparse_distance) {
  return 2 * std::asin(std::min(1.0, 0.5 / sparse_distance)) * degrees;
}

std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg) {
  const std::vector<Ray> rays = gather_rays(offsets);
  // The mean of a cell may be a cell's diagonal away from its directions.
  const double link =
      std::cos(std::min(std::numbers::pi, link_deg / degrees + std::numbers::sqrt3 * grain / 2));
  UnionFind sets(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (std::size_t j = i + 1; j < rays.size(); ++j)
      if (rays[i].unit.dot(rays[j].unit) >= link)
        sets.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
  std::map<std::uint32_t, BridgeSide> sides;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    BridgeSide& side =
        sides.try_emplace(sets.find(static_cast<std::uint32_t>(i)), BridgeSide{.distance = rays[i].distance})
            .first->second;
    side.direction += static_cast<double>(rays[i].states) * rays[i].unit;
    side.states += rays[i].states;
    side.distance = std::min(side.distance, rays[i].distance);
  }
  std::vector<BridgeSide> result;
  for (auto& [root, side] : sides) {
    // A side that surrounds the place has no mean direction.
    const double length = side.direction.norm();
    side.direction = length > 1e-9 ? Vec3(side.direction / length) : Vec3(Vec3::UnitX());
    double least = 1;
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (sets.find(static_cast<std::uint32_t>(i)) == root)
        least = std::min(least, side.direction.dot(rays[i].unit));
    side.half_angle_deg = std::acos(std::clamp(least, -1.0, 1.0)) * degrees;
    result.push_back(side);
  }
  std::ranges::stable_sort(result, {}, &BridgeSide::distance);
  return result;
}

double rim_reach(double sparse_distance, double spacing) {
  return (sparse_distance + 0.5) * spacing;
}

void find_sides(std::vector<RegionComponent>& components, double sparse_distance, const StatesNear& near) {
  std::size_t done = 0;
  std::vector<Vec3> offsets;
  for (RegionComponent& c : components) {
    if (c.label != Label::gap || done++ >= most_bridges) continue;
    offsets.clear();
    near(c.inner, offsets);
    c.sides = bridge_sides(offsets, bridge_link_deg(sparse_distance));
  }
}

}  // namespace forefeel
