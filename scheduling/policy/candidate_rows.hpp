#pragma once
// Candidates sorted by the cubes of a grid. All candidates near a position lie in a few contiguous runs of
// one array.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scheduling/policy/policy.hpp"

namespace forefeel {

class CandidateRows {
 public:
  // side: of the cubes [m]. It is doubled until there are at least four candidates per cube.
  CandidateRows(std::span<const Candidate> candidates, double side);

  const double* xyz() const { return xyz_.data(); }  // 3 x #candidates, one coordinate per row [m]
  // Index of the candidate in a column of xyz.
  std::uint32_t candidate(std::size_t place) const { return order_[place]; }

  // Calls visit(first, last) for disjoint runs of columns. They hold all candidates within `radius` of q, and
  // some that are farther.
  template <class Visit>
  void near(const Vec3& q, double radius, Visit&& visit) const;

 private:
  std::int64_t cube(double x, int axis, std::int64_t most) const {
    return static_cast<std::int64_t>(
        std::clamp((x - low_[axis]) * per_side_, 0.0, static_cast<double>(most)));
  }
  void count_cubes(const Vec3& high);
  std::uint32_t cube_of(const Vec3& x) const;

  double per_side_;  // cubes a metre
  std::size_t count_;
  Vec3 low_;
  std::int64_t cubes_[3]{};
  std::vector<std::uint32_t> begin_;  // #cubes + 1: first column of each cube
  std::vector<std::uint32_t> order_;  // column -> candidate
  std::vector<double> xyz_;           // 3 x #candidates, by column
};

template <class Visit>
void CandidateRows::near(const Vec3& q, double radius, Visit&& visit) const {
  std::array<std::int64_t, 3> from{}, until{};
  for (int k = 0; k < 3; ++k) {
    if (q[k] + radius < low_[k]) return;
    from[static_cast<std::size_t>(k)] = cube(q[k] - radius, k, cubes_[k]);
    until[static_cast<std::size_t>(k)] = cube(q[k] + radius, k, cubes_[k] - 1);
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (from[k] > until[k]) return;
  const auto run = [&](std::int64_t i, std::int64_t j, std::int64_t i_last, std::int64_t j_last) {
    const std::size_t
        first = begin_[static_cast<std::size_t>((i * cubes_[1] + j) * cubes_[2] + from[2])],
        last = begin_[static_cast<std::size_t>((i_last * cubes_[1] + j_last) * cubes_[2] + until[2]) + 1];
    if (first < last) visit(first, last);
  };
  const auto whole = [&](std::size_t k) { return from[k] == 0 && until[k] == cubes_[k] - 1; };
  if (whole(2) && whole(1)) return run(from[0], 0, until[0], until[1]);
  for (std::int64_t i = from[0]; i <= until[0]; ++i) {
    if (whole(2)) {
      run(i, from[1], i, until[1]);
      continue;
    }
    for (std::int64_t j = from[1]; j <= until[1]; ++j) run(i, j, i, j);
  }
}

}  // namespace forefeel
