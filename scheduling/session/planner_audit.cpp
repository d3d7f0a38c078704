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
  if (setup_.options.audit <= 0 || setup_.surface || setup_.model.method != SessionMethod::rbf ||
      space_.size() < 4)
    return false;
  const double drawn = random::uniform(random::mix(random::mix(setup_.seed, stream), audit_draws_++));
  const Vec3 at = hip_.at;
  if (drawn >= setup_.options.audit || !space_.options().box.contains(at)) return false;
  const double least = least_distance * space_.options().spacing;
  const auto near = [&](const Vec3& p) { return (p - at).norm() < least; };
  std::vector<StateId> nearest;
  space_.nearest(at, 1, nearest);
  const bool failed_near = std::ranges::any_of(
      log_.rows(), [&](const DispatchRecord& d) { return d.status == DispatchStatus::failed && near(d.at); });
  if (failed_near || near(space_[nearest[0]].at) || std::ranges::any_of(ranking_.pending(), near))
    return false;
  const Candidate audit{
      .at = at,
      .region = space_.region_label(at),
      .requested = now,
      .delta = (space_[nearest[0]].at - at).norm(),
      .order = std::numeric_limits<std::uint32_t>::max() - static_cast<std::uint32_t>(log_.rows().size()),
      .passing = true};
  Slot& slot = dispatch(worker, audit, 0, {}, now);
  slot.purpose = Purpose::audit;
  log_[slot.members.front().dispatch].choice.audit = true;
  ranking_.pend(at);
  return true;
}

}  // namespace forefeel
