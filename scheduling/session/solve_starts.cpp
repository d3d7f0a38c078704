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
    return (a.site + a.at - hip).squaredNorm() < (b.site + b.at - hip).squaredNorm();
  });
  *far = std::move(start);
}

const SolveStarts::Start* SolveStarts::nearest(const Candidate& candidate) const {
  const Vec3 x = candidate.displacement();
  const Start* best = nullptr;
  double distance = x.squaredNorm();
  for (const Start& start : starts_) {
    const double apart = candidate.site.exists() ? (start.site - candidate.site.at).norm() : 0;
    const double way = apart + (start.at - x).norm();
    const double d = apart > 0 ? way * way : (start.at - x).squaredNorm();
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
