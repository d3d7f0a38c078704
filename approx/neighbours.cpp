#include "approx/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {
namespace {

constexpr double loyalty = 0.95;  // of the distance of a member of the last set
constexpr std::size_t most_candidates = 8192;
constexpr double shell = 2.5;       // spacings behind the nearest state that decide where a side lies
constexpr double pulled_to = 0.25;  // spacings before the nearest state of a side

}  // namespace

NeighbourSelector::NeighbourSelector(const StateSpace& space, const ModelOptions& options)
    : space_(space), n_(options.neighbours), rule_(options.select) {
  const std::size_t room = std::max(most_candidates, 2 * n_ + 16);
  found_.reserve(room);
  candidates_.reserve(room);
  last_.reserve(n_);
  chosen_.reserve(n_ + 1);
}

void NeighbourSelector::forget() {
  last_.clear();
}

// The candidates: the states within the radius of q, or the `least` nearest to it if those are more.
void NeighbourSelector::gather(const Vec3& q, std::size_t least, double radius) {
  found_.clear();
  if (radius > 0) space_.within(q, radius, found_);
  if (found_.size() < least)
    space_.nearest(q, least, found_);
  else if (found_.size() > most_candidates)
    space_.nearest(q, most_candidates, found_);
  candidates_.clear();
  for (const StateId id : found_) candidates_.push_back({(space_[id].at - q).norm(), id, 1});
}

void NeighbourSelector::prefer_members() {
  for (Candidate& c : candidates_)
    if (std::ranges::binary_search(last_, c.id)) c.key *= loyalty;
}

void NeighbourSelector::keep_first(std::uint8_t side, std::size_t count) {
  const auto end = std::partition(candidates_.begin(), candidates_.end(),
                                  [&](const Candidate& c) { return c.side == side; });
  const auto before = [](const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key < b.key : a.id < b.id;
  };
  count = std::min(count, static_cast<std::size_t>(end - candidates_.begin()));
  const auto middle = candidates_.begin() + static_cast<std::ptrdiff_t>(count);
  if (middle != end) std::nth_element(candidates_.begin(), middle, end, before);
  for (auto c = candidates_.begin(); c != middle; ++c) chosen_.push_back(c->id);
}

void NeighbourSelector::take_nearest(const Vec3& hip) {
  gather(hip, n_ + n_ / 4 + 8, 0);
  prefer_members();
  keep_first(1, n_);
}

// Mean direction from the HIP of a side's states (0: both), counting those at most `shell` farther than its
// nearest, whose distance is returned too. The length of the mean tells how one-sided they lie.
Vec3 NeighbourSelector::towards(const Vec3& hip, std::uint8_t side, double& distance) const {
  const double deep = shell * space_.options().spacing;
  distance = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates_)
    if (side == 0 || c.side == side) distance = std::min(distance, c.key);
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (const Candidate& c : candidates_) {
    if ((side != 0 && c.side != side) || c.key > distance + deep) continue;
    if (c.key > 0) sum += (space_[c.id].at - hip) / c.key;
    ++count;
  }
  return count > 0 ? Vec3(sum / count) : sum;
}

void NeighbourSelector::take_sides(const Vec3& hip) {
  const double h = space_.options().spacing, limit = space_.options().coverage.gap_cone_radius * h;
  gather(hip, n_ + n_ / 4 + 8, limit);
  if (candidates_.empty()) return;
  const auto split = [&](const Vec3& axis) {
    for (Candidate& c : candidates_) c.side = (space_[c.id].at - hip).dot(axis) >= 0 ? 1 : 2;
  };
  double d1, d2;
  const Vec3 all = towards(hip, 0, d1);
  const auto nearest = std::ranges::min_element(candidates_, {}, &Candidate::key);
  split(all.norm() > 0.2 ? all
                         : Vec3(space_[nearest->id].at - hip));  // in the middle of a gap the mean is nothing
  split(towards(hip, 1, d1));
  const Vec3 to1 = towards(hip, 1, d1).normalized(), to2 = towards(hip, 2, d2).normalized();

  double share = 0;
  if (d2 < limit && d1 + d2 > 0) share = d1 / (d1 + d2) * std::clamp((limit - d2) / (1.5 * h), 0.0, 1.0);
  const auto second = static_cast<std::size_t>(std::lround(share * double(n_)));
  const auto take = [&](std::uint8_t side, const Vec3& to, double distance, std::size_t count) {
    gather(hip + to * std::max(0.0, distance - pulled_to * h), n_ + n_ / 4 + 8, 0);
    if (second > 0) split(to1);
    for (Candidate& c : candidates_) c.side = second == 0 ? side : c.side;
    prefer_members();
    keep_first(side, count);
  };
  if (second > 0) take(2, to2, d2, second);
  take(1, to1, d1, n_ - chosen_.size());
}

Label NeighbourSelector::select(const Vec3& hip, std::vector<StateId>& out) {
  out.clear();
  if (space_.empty()) return Label::blank;
  const Label label = space_.label(hip);
  if (rule_ == Select::nearest) {
    space_.nearest(hip, n_, out);
    std::ranges::sort(out);
    return label;
  }
  chosen_.clear();
  if (label == Label::safe || space_.size() <= n_)  // where all fit there is nothing to choose
    take_nearest(hip);
  else
    take_sides(hip);
  std::ranges::sort(chosen_);
  last_.assign(chosen_.begin(), chosen_.end());
  out.assign(chosen_.begin(), chosen_.end());
  return label;
}

}  // namespace forefeel
