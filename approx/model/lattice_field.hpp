#pragma once
// Interpolation in the lattice {k h}^3 of known states: trilinear, or tricubic by cubic convolution.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

namespace detail {
// Index of the point nearest to x, the first of equals. O(n).
std::size_t nearest_of(const std::vector<Vec3>& points, const Vec3& x);
}  // namespace detail

// The states by their lattice position; states off the lattice are left out.
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
  static Vec3 into(const Index& cell, const Vec3& k);  // what of the cell is nearest to k, in spacings
  Vec3 inside(const Index& cell, const Vec3& k) const;

  double spacing_;
  bool cubic_;
  std::unordered_map<std::uint64_t, Vec3> forces_;
  std::vector<Index> whole_;  // cells with all corners, by the lowest of them
  std::vector<Vec3> points_, values_;
};

}  // namespace forefeel
