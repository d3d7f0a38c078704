#pragma once
// Interpolates forces in the lattice {k h}^3 of known states. With k the lattice cell of x and t = x / h - k,
//   f(x) = sum over i, j, l of w_i(t_1) w_j(t_2) w_l(t_3) f(h (k + (i, j, l)))     [N]
//   trilinear   i, j, l in {0, 1},         w_0(t) = 1 - t, w_1(t) = t
//   tricubic    i, j, l in {-1, 0, 1, 2},  w: cubic convolution with a = -1/2 (R. G. Keys, IEEE Transactions on
//               Acoustics, Speech, and Signal Processing 29, 1981); values missing beyond the border are extrapolated,
//               quadratically where three states are in line
// h [m]: spacing; t is in [0, 1]^3. Only cells with all eight corners known are used. If x is outside of them, the
// force is the value at the nearest point of such a cell, or that of the nearest state if this is nearer. It is zero
// without states, and where x is not finite. Outside the cells an evaluation takes O(n).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

namespace detail {
// Index of the point nearest to x, the first of equals. O(n).
std::size_t nearest_of(const std::vector<Vec3>& points, const Vec3& x);
}  // namespace detail

// What a field gives where x lies in no full cell.
inline constexpr const char* instead_of_cells =
    "the force there is that at the nearest point of a full cell, or of the nearest state if that is nearer";

// The lattice positions of known states, and the cells that they fill: whether a field of these interpolates at x.
class LatticeCells {
 public:
  explicit LatticeCells(double spacing) : spacing_(spacing) {}
  void add(const Vec3& state);       // without effect where it is off the lattice
  bool around(const Vec3& x) const;  // x lies in a cell with all eight corners, its faces included

 private:
  double spacing_;
  std::unordered_set<std::uint64_t> known_;
};

// Cells are made of states on the lattice only. States off the lattice count only as the nearest state.
class LatticeField {
 public:
  LatticeField(std::span<const State> states, double spacing, bool cubic);
  Vec3 force(const Vec3& x) const;
  std::size_t size() const { return forces_.size(); }

 private:
  using Index = std::array<std::int32_t, 3>;
  const Vec3* at(const Index& index) const;
  Vec3 ghost(Index index, const Index& cell, int axis) const;
  bool whole(const Index& cell) const;
  static Vec3 into(const Index& cell, const Vec3& k);  // the point of the cell nearest to k, in spacings
  Vec3 inside(const Index& cell, const Vec3& k) const;

  double spacing_;
  bool cubic_;
  std::unordered_map<std::uint64_t, Vec3> forces_;
  std::vector<Index> whole_;  // cells with all corners, by the lowest of them
  std::vector<Vec3> points_, values_;
};

}  // namespace forefeel
