// Chooses which solves are audits. A random share of the jobs is solved at the present position of the HIP instead of
// the position chosen by the policy. The score of the frame rendered there is typical of what the hand feels
// (render/bar_keeper.hpp).

#include <algorithm>
#include <limits>
#include <vector>

#include "scheduling/motion/random.hpp"
#include "scheduling/session/planner.hpp"

namespace forefeel {
namespace {

// Least distance to another state [spacings]. Nearer, the fit becomes ill-conditioned and the audit gives no
// information.
constexpr double least_distance = 0.1;
constexpr std::uint64_t stream = 0xa0d17;  // of the seed

}  // namespace

bool Planner::audits(int worker, double now) {
  if (setup_.audits.share <= 0 || setup_.model.method != SessionMethod::rbf || space_.size() < 4)
    return false;
  const double drawn = random::uniform(random::mix(random::mix(setup_.audits.seed, stream), audit_draws_++));
  const Vec3 at = hip_.at;
  if (drawn >= setup_.audits.share || !space_.options().box.contains(at)) return false;
  const double least = least_distance * space_.options().spacing;
  const auto near = [&](const Vec3& p) { return (p - at).norm() < least; };
  std::vector<StateId> nearest;
  space_.nearest(at, 1, nearest);
  const bool failed_near = std::ranges::any_of(
      dispatches_, [&](const DispatchRecord& d) { return d.status == DispatchStatus::failed && near(d.at); });
  if (failed_near || near(space_[nearest[0]].at) || std::ranges::any_of(pending_, near)) return false;
  const Candidate audit{
      .at = at,
      .region = space_.region_label(at),
      .requested = now,
      .delta = (space_[nearest[0]].at - at).norm(),
      .order = std::numeric_limits<std::uint32_t>::max() - static_cast<std::uint32_t>(dispatches_.size()),
      .passing = true};
  dispatch(worker, audit, 0, {}, now);
  dispatches_.back().audit = slots_[static_cast<std::size_t>(worker)].audit = true;
  pending_.push_back(at);
  return true;
}

}  // namespace forefeel
