#include "approx/model/lattice_field.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace forefeel {

namespace {

std::uint64_t key_of(const std::array<std::int32_t, 3>& i) {
  constexpr std::uint64_t mask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(i[0]) & mask) << 42 | (static_cast<std::uint64_t>(i[1]) & mask) << 21 |
         (static_cast<std::uint64_t>(i[2]) & mask);
}

using Position = std::array<std::int32_t, 3>;  // on the lattice

// The lattice position at x, if x is one.
std::optional<Position> position_of(const Vec3& x, double spacing) {
  Position index;
  for (std::size_t d = 0; d < 3; ++d) {
    const double k = x[Eigen::Index(d)] / spacing;
    if (!(std::abs(k) < 1e6 && std::abs(k - std::round(k)) < 1e-6)) return {};
    index[d] = static_cast<std::int32_t>(std::lround(k));
  }
  return index;
}

// Cubic convolution (a = -1/2) through the values at -1, 0, 1, 2.
std::array<double, 4> cubic_weights(double t) {
  return {0.5 * t * (-1 + t * (2 - t)), 1 + 0.5 * t * t * (3 * t - 5), 0.5 * t * (1 + t * (4 - 3 * t)),
          0.5 * t * t * (t - 1)};
}

}  // namespace

void LatticeCells::add(const Vec3& state) {
  if (const std::optional<Position> index = position_of(state, spacing_)) known_.insert(key_of(*index));
}

bool LatticeCells::around(const Vec3& x) const {
  const Vec3 k = x / spacing_;
  if (!(k.cwiseAbs().maxCoeff() < 1e6)) return false;
  const auto full = [&](const Position& cell) {
    for (int corner = 0; corner < 8; ++corner)
      if (!known_.contains(
              key_of({cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)})))
        return false;
    return true;
  };
  for (int side = 0; side < 8; ++side) {  // on a face, the cells of both sides
    Position cell;
    for (std::size_t d = 0; d < 3; ++d)
      cell[d] = static_cast<std::int32_t>(std::floor(k[Eigen::Index(d)] + (side >> d & 1 ? 1e-6 : -1e-6)));
    if (full(cell)) return true;
  }
  return false;
}

LatticeField::LatticeField(std::span<const State> states, double spacing, bool cubic)
    : spacing_(spacing), cubic_(cubic) {
  for (const State& s : states) {
    if (!s.usable()) continue;
    points_.push_back(s.at);
    values_.push_back(s.force);
    const std::optional<Position> index = position_of(s.at, spacing);
    if (!index) continue;
    forces_[key_of(*index)] = s.force;
    whole_.push_back(*index);
  }
  std::erase_if(whole_, [&](const Index& cell) { return !whole(cell); });
}

const Vec3* LatticeField::at(const Index& index) const {
  const auto found = forces_.find(key_of(index));
  return found == forces_.end() ? nullptr : &found->second;
}

bool LatticeField::whole(const Index& cell) const {
  for (int corner = 0; corner < 8; ++corner)
    if (at({cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)}) == nullptr)
      return false;
  return true;
}

// The value at index; if no state is known there, extrapolated axis by axis from inside the cell.
Vec3 LatticeField::ghost(Index index, const Index& cell, int axis) const {
  if (const Vec3* known = at(index)) return *known;
  for (; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int step = index[a] < cell[a] ? 1 : index[a] > cell[a] + 1 ? -1 : 0;
    if (step == 0) continue;
    const auto shifted = [&](int by) {
      Index moved = index;
      moved[a] += by * step;
      return moved;
    };
    const auto in_line = [&](Index moved) {  // known on the line through the cell itself?
      for (std::size_t d = 0; d < 3; ++d)
        if (d != a) moved[d] = std::clamp(moved[d], cell[d], cell[d] + 1);
      return at(moved) != nullptr;
    };
    if (in_line(index)) continue;  // not this axis leads out
    const Vec3 one = ghost(shifted(1), cell, axis + 1), two = ghost(shifted(2), cell, axis + 1);
    if (!in_line(shifted(3))) return 2 * one - two;
    return 3 * one - 3 * two + ghost(shifted(3), cell, axis + 1);
  }
  for (std::size_t d = 0; d < 3; ++d) index[d] = std::clamp(index[d], cell[d], cell[d] + 1);
  return *at(index);  // a ragged border: the cell's own corner
}

Vec3 LatticeField::force(const Vec3& x) const {
  if (points_.empty() || !x.allFinite()) return Vec3::Zero();
  const Vec3 k = x / spacing_;
  if (k.cwiseAbs().maxCoeff() < 1e6) {
    Index cell;
    for (std::size_t d = 0; d < 3; ++d) cell[d] = static_cast<std::int32_t>(std::floor(k[Eigen::Index(d)]));
    if (whole(cell)) return inside(cell, k);
  }
  const std::size_t nearest = detail::nearest_of(points_, x);
  double least = (points_[nearest] / spacing_ - k).squaredNorm();
  const Index* best = nullptr;
  for (const Index& cell : whole_)
    if (const double apart = (into(cell, k) - k).squaredNorm(); apart < least) {
      least = apart;
      best = &cell;
    }
  return best == nullptr ? values_[nearest] : inside(*best, into(*best, k));
}

Vec3 LatticeField::into(const Index& cell, const Vec3& k) {
  const Vec3 low(cell[0], cell[1], cell[2]);
  return k.cwiseMax(low).cwiseMin(low + Vec3::Ones());
}

// k: position in spacings, in the cell.
Vec3 LatticeField::inside(const Index& cell, const Vec3& k) const {
  const double t[3] = {k[0] - cell[0], k[1] - cell[1], k[2] - cell[2]};
  Vec3 sum = Vec3::Zero();
  if (!cubic_) {
    for (int c = 0; c < 8; ++c) {
      const int i = c & 1, j = c >> 1 & 1, l = c >> 2;
      sum += (i ? t[0] : 1 - t[0]) * (j ? t[1] : 1 - t[1]) * (l ? t[2] : 1 - t[2]) *
             *at({cell[0] + i, cell[1] + j, cell[2] + l});
    }
    return sum;
  }
  const auto wx = cubic_weights(t[0]), wy = cubic_weights(t[1]), wz = cubic_weights(t[2]);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int l = 0; l < 4; ++l)
        sum += wx[std::size_t(i)] * wy[std::size_t(j)] * wz[std::size_t(l)] *
               ghost({cell[0] + i - 1, cell[1] + j - 1, cell[2] + l - 1}, cell, 0);
  return sum;
}

namespace detail {

std::size_t nearest_of(const std::vector<Vec3>& points, const Vec3& x) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if ((points[i] - x).squaredNorm() < (points[best] - x).squaredNorm()) best = i;
  return best;
}

}  // namespace detail

}  // namespace forefeel
