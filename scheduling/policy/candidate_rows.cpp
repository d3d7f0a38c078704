#include "scheduling/policy/candidate_rows.hpp"

#include <limits>

namespace forefeel {

void CandidateRows::count_cubes(const Vec3& high) {
  for (int k = 0; k < 3; ++k) cubes_[k] = cube(high[k], k, 1 << 20) + 1;
}

CandidateRows::CandidateRows(std::span<const Candidate> candidates, double side)
    : per_side_(1 / side), count_(candidates.size()) {
  const Vec3 far = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -far;
  low_ = far;
  for (const Candidate& c : candidates) low_ = low_.cwiseMin(c.at), high = high.cwiseMax(c.at);
  count_cubes(high);
  while (cubes_[0] * cubes_[1] * cubes_[2] >
         std::max<std::int64_t>(1, static_cast<std::int64_t>(count_ / 4))) {
    per_side_ /= 2;
    count_cubes(high);
  }
  begin_.assign(static_cast<std::size_t>(cubes_[0] * cubes_[1] * cubes_[2]) + 1, 0);
  std::vector<std::uint32_t> of(count_);
  for (std::size_t i = 0; i < count_; ++i) ++begin_[(of[i] = cube_of(candidates[i].at)) + 1];
  for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  order_.resize(count_);
  xyz_.resize(3 * count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t place = next[of[i]]++;
    order_[place] = static_cast<std::uint32_t>(i);
    for (unsigned k = 0; k < 3; ++k) xyz_[k * count_ + place] = candidates[i].at[k];
  }
}

std::uint32_t CandidateRows::cube_of(const Vec3& x) const {
  std::int64_t row = 0;
  for (int k = 0; k < 3; ++k) row = row * cubes_[k] + cube(x[k], k, cubes_[k] - 1);
  return static_cast<std::uint32_t>(row);
}

}  // namespace forefeel
