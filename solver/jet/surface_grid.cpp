#include "solver/jet/surface_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solver/body/pad_quadrature.hpp"

namespace forefeel {
namespace {

constexpr double cells_along = 48;      // the longest side of the body
constexpr std::size_t most_cells = 64;  // that a short way touches; a longer way looks at every facet
constexpr double rim = 1e-9;            // of barycentric coordinates, so that no way slips between two pieces
constexpr int cuts = 4;                 // of each edge of a facet that is not flat

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

void SurfaceGrid::cut(std::int32_t facet) {
  const bool flat = map_.smooth().is_flat(facet);
  const int parts = flat ? 1 : cuts;
  const auto add = [&](const std::array<Vec3, 3>& share) {
    Piece piece{.facet = facet, .corner = map_.corners(facet), .share = share};
    for (std::size_t i = 0; i < 3 && !flat; ++i) piece.corner[i] = map_.place(facet, share[i]).at;
    piece.normal = (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]).normalized();
    const Vec3 middle = (piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3;
    if (!flat)
      off_ = std::max(off_, 2 * (map_.place(facet, (share[0] + share[1] + share[2]) / 3).at - middle).norm());
    pieces_.push_back(piece);
  };
  const auto at = [&](int i, int j) { return Vec3(Vec3(parts - i - j, i, j) / parts); };
  for (int i = 0; i < parts; ++i)
    for (int j = 0; i + j < parts; ++j) {
      add({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j + 1 < parts) add({at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)});
    }
}

SurfaceGrid::SurfaceGrid(const SurfaceMap& map) : map_(map) {
  for (std::size_t f = 0; f < map.facets().size(); ++f) cut(static_cast<std::int32_t>(f));
  Vec3 high = Vec3::Constant(-1e300);
  low_ = Vec3::Constant(1e300);
  for (const Piece& piece : pieces_)
    for (const Vec3& corner : piece.corner) low_ = low_.cwiseMin(corner), high = high.cwiseMax(corner);
  side_ = (high - low_).maxCoeff() / cells_along;
  low_.array() -= 1.5 * side_;  // a rim of cells outside
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    cells_[i] = static_cast<int>(std::ceil((high[k] - low_[k]) / side_)) + 2;
  }
  const std::size_t all = number(cells_[0] - 1, cells_[1] - 1, cells_[2] - 1) + 1;
  std::vector<std::vector<std::int32_t>> lists(all);
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const std::array<Vec3, 3>& corner = pieces_[p].corner;
    const Vec3 margin = Vec3::Constant(1e-6 * side_ + off_);
    const Cells reached = cells_of(corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]) - margin,
                                   corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]) + margin);
    for (int x = reached.low[0]; x <= reached.high[0]; ++x)
      for (int y = reached.low[1]; y <= reached.high[1]; ++y)
        for (int z = reached.low[2]; z <= reached.high[2]; ++z) {
          // The plane of the piece passes the cell.
          const Vec3 from_plane = centre(x, y, z) - corner[0];
          const Vec3& n = pieces_[p].normal;
          if (std::abs(n.dot(from_plane)) <= 0.501 * side_ * n.cwiseAbs().sum() + off_)
            lists[number(x, y, z)].push_back(static_cast<std::int32_t>(p));
        }
  }
  begin_.push_back(0);
  for (const std::vector<std::int32_t>& list : lists) {
    reaching_.insert(reaching_.end(), list.begin(), list.end());
    begin_.push_back(static_cast<std::uint32_t>(reaching_.size()));
  }
  // Centres along z: as the one before, unless a piece lies between. The first cell of each row is outside.
  centre_is_inside_.assign(all, 0);
  for (int x = 0; x < cells_[0]; ++x)
    for (int y = 0; y < cells_[1]; ++y)
      for (int z = 1; z < cells_[2]; ++z) {
        const std::size_t here = number(x, y, z), before = number(x, y, z - 1);
        const std::optional<int> between =
            crossings_between(before, here, centre(x, y, z - 1), centre(x, y, z));
        const bool inside = between ? (centre_is_inside_[before] != 0) == (*between % 2 == 0)
                                    : inside_by_angle(centre(x, y, z));
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
    const std::optional<int> one = crossed(from, to, pieces_[static_cast<std::size_t>(reaching_[i])].corner);
    if (!one) return {};
    count += std::abs(*one);
  }
  return count;
}

std::optional<int> SurfaceGrid::crossings_between(std::size_t cell, std::size_t beside, const Vec3& from,
                                                  const Vec3& to) const {
  std::vector<std::int32_t> both(reaching_.begin() + begin_[cell], reaching_.begin() + begin_[cell + 1]);
  both.insert(both.end(), reaching_.begin() + begin_[beside], reaching_.begin() + begin_[beside + 1]);
  std::ranges::sort(both);
  both.erase(std::unique(both.begin(), both.end()), both.end());
  int count = 0;
  for (const std::int32_t p : both) {
    const std::optional<int> one = crossed(from, to, pieces_[static_cast<std::size_t>(p)].corner);
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
  if (const std::optional<bool> by_foot = inside_by_foot(point, cell)) return *by_foot;
  const std::optional<int> count = crossings(middle, point, cell);
  return count ? as_middle == (*count % 2 == 0) : inside_by_angle(point);
}

bool SurfaceGrid::inside_by_angle(const Vec3& point) const {
  double angle = 0;  // A. van Oosterom and J. Strackee, The solid angle of a plane triangle, 1983
  for (const Piece& piece : pieces_) {
    const Vec3 a = piece.corner[0] - point, b = piece.corner[1] - point, c = piece.corner[2] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle > 2 * std::numbers::pi;
}

// None: no piece that is not flat is so near.
std::optional<bool> SurfaceGrid::inside_by_foot(const Vec3& point, std::size_t cell) const {
  double least = off_;
  std::optional<bool> is_inside;
  for (std::uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
    const Piece& piece = pieces_[static_cast<std::size_t>(reaching_[i])];
    if (map_.smooth().is_flat(piece.facet)) continue;
    const auto& [a, b, c] = piece.corner;
    const Vec3 at = pad_quadrature::nearest_in_triangle(point, a, b, c);
    if (!((at - point).norm() <= least)) continue;
    least = (at - point).norm();
    const SurfacePlace foot = map_.foot_near({piece.facet, at}, point);
    is_inside = map_.spot(foot).normal.dot(point - foot.at) < 0;
  }
  return is_inside;
}

// Where the way meets the smooth surface near a point of a piece, by Newton's method.
SurfacePlace SurfaceGrid::on_surface(const Piece& piece, const Vec3& at, const Vec3& way) const {
  if (map_.smooth().is_flat(piece.facet)) return {piece.facet, at};
  constexpr int most_steps = 8;
  const Vec3 along = way.normalized();
  SurfacePlace place = map_.foot_near({piece.facet, at}, at);
  for (int i = 0; i < most_steps; ++i) {
    const Vec3 left = at - place.at, normal = map_.spot(place).normal;
    const double slant = normal.dot(along);
    if (std::abs(slant) < 0.1) break;  // along the surface
    const Vec3 step = left - normal.dot(left) / slant * along;
    if (step.norm() < 1e-12) break;
    place = map_.walk(place, step).end;
  }
  return place;
}

std::optional<SurfacePlace> SurfaceGrid::crossing(const Vec3& outside, const Vec3& inside) const {
  // A little longer, as the pieces may lie before or behind the surface.
  const double length = (inside - outside).norm();
  if (!(length > 0)) return {};
  const Vec3 along = (inside - outside) / length;
  for (const double more : {0.0, 3 * off_}) {
    const std::optional<SurfacePlace> place = first_crossing(outside - more * along, inside + more * along);
    if (!place) continue;
    const double way = along.dot(place->at - outside);
    if (way > -rim * length && way < (1 + rim) * length) return place;
  }
  return {};
}

std::optional<SurfacePlace> SurfaceGrid::first_crossing(const Vec3& outside, const Vec3& inside) const {
  const Piece* first = nullptr;
  double least = 1 + rim;
  const auto look = [&](const Piece& piece) {
    const Vec3& n = piece.normal;
    const double from = n.dot(outside - piece.corner[0]), to = n.dot(inside - piece.corner[0]);
    if (!(from >= 0 && to < 0)) return;
    const double t = from / (from - to);
    if (t >= least) return;
    const Vec3 at = outside + t * (inside - outside);
    const Vec3 &a = piece.corner[0], &b = piece.corner[1], &c = piece.corner[2];
    const double whole = n.dot((b - a).cross(c - a));
    if (std::min({n.dot((b - at).cross(c - at)), n.dot((c - at).cross(a - at)),
                  n.dot((a - at).cross(b - at))}) < -rim * whole)
      return;
    least = t, first = &piece;
  };
  const Cells way = cells_of(outside.cwiseMin(inside), outside.cwiseMax(inside));
  if (way.count() > most_cells) {
    for (const Piece& piece : pieces_) look(piece);
  } else {
    for (int x = way.low[0]; x <= way.high[0]; ++x)
      for (int y = way.low[1]; y <= way.high[1]; ++y)
        for (int z = way.low[2]; z <= way.high[2]; ++z) {
          const std::size_t cell = number(x, y, z);
          for (std::uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i)
            look(pieces_[static_cast<std::size_t>(reaching_[i])]);
        }
  }
  if (!first) return {};
  return on_surface(*first, outside + least * (inside - outside), inside - outside);
}

}  // namespace forefeel
