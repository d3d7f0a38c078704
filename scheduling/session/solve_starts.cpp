#include "scheduling/session/solve_starts.hpp"

#include <algorithm>
#include <utility>

namespace forefeel {

// As many as fit half a gigabyte with their tangents (4 times the displacements).
SolveStarts::SolveStarts(std::size_t nodes)
    : most_(std::clamp<std::size_t>((std::size_t{1} << 29) / (nodes * 96 + 1), 16, 65536)) {}

void SolveStarts::remember(Start start, const Vec3& hip) {
  if (starts_.size() < most_) {
    starts_.push_back(std::move(start));
    return;
  }
  const auto far = std::max_element(starts_.begin(), starts_.end(), [&](const Start& a, const Start& b) {
    return (a.at - hip).squaredNorm() < (b.at - hip).squaredNorm();
  });
  *far = std::move(start);
}

const SolveStarts::Start* SolveStarts::nearest(const Vec3& x) const {
  const Start* best = nullptr;
  double distance = x.squaredNorm();
  for (const Start& start : starts_) {
    const double d = (start.at - x).squaredNorm();
    if (d < distance) {
      distance = d;
      best = &start;
    }
  }
  return best;
}

void SolveStarts::keep_partial(const Candidate& candidate, std::shared_ptr<const Equilibrium> last_iterate) {
  if (last_iterate) partial_[candidate.order] = std::move(last_iterate);
}

std::shared_ptr<const Equilibrium> SolveStarts::take_partial(const Candidate& candidate) {
  auto found = partial_.extract(candidate.order);
  return found ? std::move(found.mapped()) : nullptr;
}

}  // namespace forefeel
