#include "solver/jet/surface_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr double cells_along = 48;      // the longest side of the body
constexpr std::size_t most_cells = 64;  // that a short way touches; a longer way looks at every facet
constexpr double rim = 1e-9;            // of barycentric coordinates, so that no way slips between two facets

// The sign with which the way crosses the triangle, 0: not; none: it meets an edge or runs in the plane.
std::optional<int> crossed(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& corner) {
  const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).dot((c - a).cross(d - a));
  };
  const double scale = 1e-14 * (corner[1] - corner[0]).norm() * (corner[2] - corner[0]).norm() *
                       ((to - from).norm() + (corner[1] - corner[0]).norm());
  const double above = volume(corner[0], corner[1], corner[2], from),
               below = volume(corner[0], corner[1], corner[2], to);
  if (std::abs(above) <= scale || std::abs(below) <= scale) return {};
  if ((above > 0) == (below > 0)) return 0;
  const double u = volume(from, to, corner[0], corner[1]), v = volume(from, to, corner[1], corner[2]),
               w = volume(from, to, corner[2], corner[0]);
  const bool some_up = u > scale || v > scale || w > scale,
             some_down = u < -scale || v < -scale || w < -scale;
  if (some_up && some_down) return 0;
  if (std::abs(u) <= scale || std::abs(v) <= scale || std::abs(w) <= scale) return {};
  return above > 0 ? -1 : 1;
}

}  // namespace

std::size_t SurfaceGrid::Cells::count() const {
  std::size_t count = 1;
  for (std::size_t i = 0; i < 3; ++i) count *= static_cast<std::size_t>(std::max(0, high[i] - low[i] + 1));
  return count;
}

SurfaceGrid::SurfaceGrid(const SurfaceMap& map) : map_(map) {
  Vec3 high = Vec3::Constant(-1e300);
  low_ = Vec3::Constant(1e300);
  const auto count = static_cast<std::int32_t>(map.facets().size());
  for (std::int32_t f = 0; f < count; ++f)
    for (const Vec3& corner : map.corners(f)) low_ = low_.cwiseMin(corner), high = high.cwiseMax(corner);
  side_ = (high - low_).maxCoeff() / cells_along;
  low_.array() -= 1.5 * side_;  // a rim of cells outside
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    cells_[i] = static_cast<int>(std::ceil((high[k] - low_[k]) / side_)) + 2;
  }
  const std::size_t all = number(cells_[0] - 1, cells_[1] - 1, cells_[2] - 1) + 1;
  std::vector<std::vector<std::int32_t>> lists(all);
  for (std::int32_t f = 0; f < count; ++f) {
    const std::array<Vec3, 3> corner = map.corners(f);
    const Vec3 margin = Vec3::Constant(1e-6 * side_);
    const Cells reached = cells_of(corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]) - margin,
                                   corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]) + margin);
    for (int x = reached.low[0]; x <= reached.high[0]; ++x)
      for (int y = reached.low[1]; y <= reached.high[1]; ++y)
        for (int z = reached.low[2]; z <= reached.high[2]; ++z) {
          // The plane of the facet passes the cell.
          const Vec3 from_plane = centre(x, y, z) - corner[0];
          const Vec3& n = map.facets()[static_cast<std::size_t>(f)].normal;
          if (std::abs(n.dot(from_plane)) <= 0.501 * side_ * n.cwiseAbs().sum())
            lists[number(x, y, z)].push_back(f);
        }
  }
  begin_.push_back(0);
  for (const std::vector<std::int32_t>& list : lists) {
    facets_.insert(facets_.end(), list.begin(), list.end());
    begin_.push_back(static_cast<std::uint32_t>(facets_.size()));
  }
  // Centres along z: as the one before, unless a facet lies between. The first cell of each row is outside.
  centre_is_inside_.assign(all, 0);
  for (int x = 0; x < cells_[0]; ++x)
    for (int y = 0; y < cells_[1]; ++y)
      for (int z = 1; z < cells_[2]; ++z) {
        const std::size_t here = number(x, y, z), before = number(x, y, z - 1);
        const std::optional<int> between =
            crossings_between(before, here, centre(x, y, z - 1), centre(x, y, z));
        const bool inside =
            between ? (centre_is_inside_[before] != 0) == (*between % 2 == 0) : map.inside(centre(x, y, z));
        centre_is_inside_[here] = inside ? 1 : 0;
      }
}

std::size_t SurfaceGrid::number(int x, int y, int z) const {
  return static_cast<std::size_t>((x * cells_[1] + y) * cells_[2] + z);
}

Vec3 SurfaceGrid::centre(int x, int y, int z) const {
  return low_ + side_ * Vec3(x + 0.5, y + 0.5, z + 0.5);
}

SurfaceGrid::Cells SurfaceGrid::cells_of(const Vec3& low, const Vec3& high) const {
  Cells cells;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double last = cells_[i] - 1;
    cells.low[i] = static_cast<int>(std::clamp(std::floor((low[k] - low_[k]) / side_), 0.0, last));
    cells.high[i] = static_cast<int>(std::clamp(std::floor((high[k] - low_[k]) / side_), 0.0, last));
  }
  return cells;
}

std::optional<int> SurfaceGrid::crossings(const Vec3& from, const Vec3& to, std::size_t cell) const {
  int count = 0;
  for (std::uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
    const std::optional<int> one = crossed(from, to, map_.corners(facets_[i]));
    if (!one) return {};
    count += std::abs(*one);
  }
  return count;
}

std::optional<int> SurfaceGrid::crossings_between(std::size_t cell, std::size_t beside, const Vec3& from,
                                                  const Vec3& to) const {
  std::vector<std::int32_t> both(facets_.begin() + begin_[cell], facets_.begin() + begin_[cell + 1]);
  both.insert(both.end(), facets_.begin() + begin_[beside], facets_.begin() + begin_[beside + 1]);
  std::ranges::sort(both);
  both.erase(std::unique(both.begin(), both.end()), both.end());
  int count = 0;
  for (const std::int32_t f : both) {
    const std::optional<int> one = crossed(from, to, map_.corners(f));
    if (!one) return {};
    count += std::abs(*one);
  }
  return count;
}

bool SurfaceGrid::inside(const Vec3& point) const {
  if (!point.allFinite()) return false;
  const Cells at = cells_of(point, point);
  const Vec3 middle = centre(at.low[0], at.low[1], at.low[2]);
  if (!((point - middle).cwiseAbs().maxCoeff() <= 0.5001 * side_)) return false;  // beyond the grid
  const std::size_t cell = number(at.low[0], at.low[1], at.low[2]);
  const bool as_middle = centre_is_inside_[cell] != 0;
  if (begin_[cell] == begin_[cell + 1]) return as_middle;
  const std::optional<int> count = crossings(middle, point, cell);
  return count ? as_middle == (*count % 2 == 0) : map_.inside(point);
}

std::optional<SurfacePlace> SurfaceGrid::crossing(const Vec3& outside, const Vec3& inside) const {
  std::optional<SurfacePlace> first;
  double least = 1 + rim;
  const auto look = [&](std::int32_t f) {
    const Vec3& n = map_.facets()[static_cast<std::size_t>(f)].normal;
    const std::array<Vec3, 3> corner = map_.corners(f);
    const double from = n.dot(outside - corner[0]), to = n.dot(inside - corner[0]);
    if (!(from >= 0 && to < 0)) return;
    const double t = from / (from - to);
    if (t >= least) return;
    const SurfacePlace place{f, outside + t * (inside - outside)};
    if (map_.barycentric(place).minCoeff() < -rim) return;
    least = t, first = place;
  };
  const Cells way = cells_of(outside.cwiseMin(inside), outside.cwiseMax(inside));
  if (way.count() > most_cells) {
    for (std::size_t f = 0; f < map_.facets().size(); ++f) look(static_cast<std::int32_t>(f));
    return first;
  }
  for (int x = way.low[0]; x <= way.high[0]; ++x)
    for (int y = way.low[1]; y <= way.high[1]; ++y)
      for (int z = way.low[2]; z <= way.high[2]; ++z) {
        const std::size_t cell = number(x, y, z);
        for (std::uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i) look(facets_[i]);
      }
  return first;
}

}  // namespace forefeel
