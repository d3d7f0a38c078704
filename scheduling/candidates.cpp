#include "scheduling/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/regions.hpp"

namespace forefeel {

Candidates::Candidates(const StateSpace& space, std::span<const State> failed) : space_(space) {
  std::unordered_map<std::uint64_t, bool> skip;
  for (const State& state : failed) skip[key(state.at)] = true;
  std::vector<StateId> nearest;
  std::uint32_t order = 0;
  for (const Vec3& x : lattice(space.options().box, space.options().spacing)) {
    const std::uint32_t mine = order++;
    if (space.find(x).valid() || skip.count(key(x))) continue;
    Candidate c{.at = x, .requested = std::numeric_limits<double>::infinity(), .order = mine};
    c.delta = std::numeric_limits<double>::infinity();
    space.nearest(x, 1, nearest);
    if (!nearest.empty()) c.delta = (space[nearest[0]].at - x).norm();
    place_[key(x)] = static_cast<std::uint32_t>(open_.size());
    open_.push_back(c);
  }
}

// Lattice points differ by a spacing, so rounding to a tenth of one tells them apart and forgives round-off.
std::uint64_t Candidates::key(const Vec3& x) const {
  std::uint64_t packed = 0;
  for (int i = 0; i < 3; ++i) {
    const auto step = std::llround(10 * x[i] / space_.options().spacing) + (1 << 20);
    packed = packed << 21 | (static_cast<std::uint64_t>(step) & 0x1fffff);
  }
  return packed;
}

Candidate Candidates::take(std::size_t i) {
  const Candidate taken = open_[i];
  place_.erase(key(taken.at));
  if (i + 1 != open_.size()) {
    open_[i] = open_.back();
    place_[key(open_[i].at)] = static_cast<std::uint32_t>(i);
  }
  open_.pop_back();
  return taken;
}

void Candidates::put_back(Candidate candidate) {
  candidate = refreshed(candidate);
  place_[key(candidate.at)] = static_cast<std::uint32_t>(open_.size());
  open_.push_back(candidate);
}

void Candidates::learn(const Vec3& known) {
  if (const auto found = place_.find(key(known)); found != place_.end()) {
    const Vec3 difference = open_[found->second].at - known;
    if (difference.norm() < 1e-6 * space_.options().spacing) take(found->second);
  }
  for (Candidate& c : open_) c.delta = std::min(c.delta, (c.at - known).norm());
  changed_ = true;
}

void Candidates::request_near(const Vec3& hip, double now) {
  const double radius = 2.5 * space_.options().spacing;
  for (Candidate& c : open_)
    if (!std::isfinite(c.requested) && (c.at - hip).squaredNorm() <= radius * radius) c.requested = now;
}

void Candidates::refresh() {
  if (!changed_) return;
  changed_ = false;
  for (Candidate& c : open_)
    if (c.region != Label::safe) c.region = space_.regions().label_at(c.at);
}

Candidate Candidates::refreshed(Candidate candidate) const {
  candidate.region = space_.regions().label_at(candidate.at);
  std::vector<StateId> nearest;
  space_.nearest(candidate.at, 1, nearest);
  if (!nearest.empty()) candidate.delta = (space_[nearest[0]].at - candidate.at).norm();
  return candidate;
}

}  // namespace forefeel
