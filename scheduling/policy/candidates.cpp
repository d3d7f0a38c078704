#include "scheduling/policy/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/coverage/design.hpp"

namespace forefeel {

namespace {
constexpr double coarsest = 4;  // width of the adaptive lattice's first leaves, in spacings
constexpr int deepest = 2;      // how often they may be split: down to the spacing
}  // namespace

LatticeCandidates::LatticeCandidates(const StateSpace& space, std::span<const State> failed,
                                     Placement placement)
    : space_(space), placement_(placement) {
  for (const State& state : failed) {
    gone_[key(state.at)] = true;
    failed_.push_back(state.at);
  }
  const double h = space.options().spacing;
  const Box& box = space.options().box;
  if (placement == Placement::adaptive) {
    leaves_ = std::make_unique<AdaptiveLattice>(box, coarsest * h);
    for (const AdaptiveLattice::Point& point : leaves_->points()) add(point.at, false);
  } else {
    for (const Vec3& x :
         placement == Placement::path ? lattice(box, 2 * h) : designed_places(space.options()))
      add(x, false);
  }
}

// Rounded to a tenth of the spacing. This distinguishes lattice points, which are a spacing apart, and
// ignores round-off. Scattered places may be nearer to each other.
std::uint64_t LatticeCandidates::key(const Vec3& x) const {
  const double parts = space_.options().design == Design::lattice ? 10 : 1000;
  std::uint64_t packed = 0;
  for (int i = 0; i < 3; ++i) {
    const auto step = std::llround(parts * x[i] / space_.options().spacing) + (1 << 20);
    packed = packed << 21 | (static_cast<std::uint64_t>(step) & 0x1fffff);
  }
  return packed;
}

// Skips a position that was a candidate before, unless it was a passing one.
void LatticeCandidates::add(const Vec3& x, bool passing) {
  const std::uint32_t mine = order_++;
  const std::uint64_t where = key(x);
  if (place_.contains(where) || gone_.contains(where) || space_.find(x).valid()) return;
  Candidate c{.at = x,
              .requested = std::numeric_limits<double>::infinity(),
              .delta = std::numeric_limits<double>::infinity(),
              .order = mine,
              .passing = passing};
  std::vector<StateId> nearest;
  space_.nearest(x, 1, nearest);
  if (!nearest.empty()) c.delta = (space_[nearest[0]].at - x).norm();
  if (placement_ == Placement::path && c.delta < 0.5 * space_.options().spacing) return;
  if (passing && (too_near(x, under_way_) || too_near(x, failed_))) return;
  open_one(c);
  changed_ = true;
}

void LatticeCandidates::open_one(const Candidate& candidate) {
  place_[key(candidate.at)] = static_cast<std::uint32_t>(open_.size());
  open_.push_back(candidate);
}

bool LatticeCandidates::too_near(const Vec3& x, std::span<const Vec3> places) const {
  const double least = 0.5 * space_.options().spacing;
  return std::ranges::any_of(places, [&](const Vec3& p) { return (x - p).squaredNorm() < least * least; });
}

std::optional<std::size_t> LatticeCandidates::index_of(const Candidate& candidate) const {
  const auto found = place_.find(key(candidate.at));
  if (found == place_.end() || open_[found->second].order != candidate.order) return {};
  return found->second;
}

Candidate LatticeCandidates::remove(std::size_t i) {
  const Candidate taken = open_[i];
  place_.erase(key(taken.at));
  if (i + 1 != open_.size()) {
    open_[i] = open_.back();
    place_[key(open_[i].at)] = static_cast<std::uint32_t>(i);
  }
  open_.pop_back();
  gone_[key(taken.at)] = true;
  return taken;
}

std::optional<Candidate> LatticeCandidates::take_rest() {
  add(Vec3::Zero(), false);  // where the placement has none; otherwise nothing changes
  const auto found = place_.find(key(Vec3::Zero()));
  if (found == place_.end()) return {};
  return take(found->second);
}

Candidate LatticeCandidates::take(std::size_t i) {
  const Candidate taken = remove(i);
  if (placement_ == Placement::path) {
    under_way_.push_back(taken.at);
    hold_back(taken.at);
  }
  return taken;
}

// Candidates too near to `at`: passing ones are dropped, those of the lattice are held back.
void LatticeCandidates::hold_back(const Vec3& at) {
  for (std::size_t i = open_.size(); i-- > 0;)
    if (too_near(open_[i].at, {&at, 1})) {
      const Candidate near = remove(i);
      if (near.passing)
        gone_.erase(key(near.at));
      else
        held_.push_back(near);
    }
}

// Held candidates with no solve nearby any more become open again; those near a known state are dropped.
void LatticeCandidates::release() {
  for (Candidate& candidate : std::exchange(held_, {})) {
    candidate = refreshed(candidate);
    if (candidate.delta < 0.5 * space_.options().spacing) continue;
    if (too_near(candidate.at, under_way_)) {
      held_.push_back(candidate);
      continue;
    }
    gone_.erase(key(candidate.at));
    open_one(candidate);
  }
}

void LatticeCandidates::put_back(Candidate candidate) {
  gone_.erase(key(candidate.at));
  std::erase(under_way_, candidate.at);
  release();
  if (candidate.passing || place_.contains(key(candidate.at))) return;  // the next step places new ones
  open_one(refreshed(candidate));
}

void LatticeCandidates::fail(const Candidate& candidate) {
  if (placement_ != Placement::path) return;
  const Vec3& at = candidate.at;
  std::erase(under_way_, at);
  failed_.push_back(at);
  release();
}

void LatticeCandidates::learn(const Candidate& state) {
  const Vec3& known = state.at;
  if (const auto found = place_.find(key(known)); found != place_.end()) {
    const Vec3 difference = open_[found->second].at - known;
    if (difference.norm() < 1e-6 * space_.options().spacing) remove(found->second);
  }
  if (placement_ == Placement::path) {
    hold_back(known);
    std::erase(under_way_, known);
    release();
  }
  for (Candidate& c : open_) c.delta = std::min(c.delta, (c.at - known).norm());
  changed_ = true;
}

void LatticeCandidates::request_near(const Vec3& hip, double now) {
  const double radius = 2.5 * space_.options().spacing;
  for (Candidate& c : open_)
    if (!std::isfinite(c.requested) && (c.at - hip).squaredNorm() <= radius * radius) c.requested = now;
}

bool LatticeCandidates::corners_are_taken(const LatticeLeaf& leaf) const {
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 share(corner & 1, (corner >> 1) & 1, corner >> 2);
    if (place_.contains(key(leaf.box.low + leaf.box.size().cwiseProduct(share)))) return false;
  }
  return true;
}

void LatticeCandidates::split_leaves(std::span<const Prediction> path) {
  const auto wanted = [&](const LatticeLeaf& leaf) {
    const bool crossed =
        std::ranges::any_of(path, [&](const Prediction& p) { return leaf.box.contains(p.at); });
    return crossed && corners_are_taken(leaf) ? 0.5 * leaf.spacing : leaf.spacing;
  };
  if (leaves_->refine(wanted, deepest) == 0) return;
  for (const AdaptiveLattice::Point& point : leaves_->points()) add(point.at, false);
}

void LatticeCandidates::follow(std::span<const Prediction> path, const HipSample&, double now) {
  if (placement_ == Placement::adaptive) split_leaves(path);
  if (placement_ != Placement::path) return;
  for (std::size_t i = open_.size(); i-- > 0;)
    if (open_[i].passing) {
      gone_.erase(key(remove(i).at));
    }
  const Box& box = space_.options().box;
  for (const Prediction& p : path) {
    add(p.at.cwiseMax(box.low).cwiseMin(box.high), true);
    if (!open_.empty() && open_.back().passing) open_.back().requested = now;
  }
}

void LatticeCandidates::refresh_regions() {
  if (!changed_) return;
  changed_ = false;
  for (Candidate& c : open_)
    if (c.region != Label::safe) c.region = space_.region_label(c.at);
}

Candidate LatticeCandidates::refreshed(Candidate candidate) const {
  candidate.region = space_.region_label(candidate.at);
  std::vector<StateId> nearest;
  space_.nearest(candidate.at, 1, nearest);
  if (!nearest.empty()) candidate.delta = (space_[nearest[0]].at - candidate.at).norm();
  return candidate;
}

}  // namespace forefeel
