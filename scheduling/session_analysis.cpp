// What is worked out after a run, exactly and in the order in which states became known:
//   label of every frame, with the states known in that frame
//   error at sampled frames against a tight solve on the reference branch, e = |F - f| / max(|f|, f0), and its parts
//     approximation |f~ - f|, switch |F - f~|, staleness |f~ - f~*|, each over max(|f|, f0), f~ the newest model,
//     f~* one made from all states known at that moment
// Samples are taken every reference_step of HIP travel, and in the first frame within each lattice cell.

#include <algorithm>
#include <cmath>
#include <future>

#include "scheduling/session_model.hpp"
#include "scheduling/session_parts.hpp"
#include "scheduling/visited_cells.hpp"

namespace forefeel {
namespace {

// Marks frames: sampled by arc length, and first visits of the cells of the lattice (cubes of h, or of a side of their
// own, whose corners lie in the box), of which every visit_stride-th counts.
void choose_samples(SessionResult& result, const SessionInput& input, const SessionOptions& options) {
  const double step = options.reference_step;
  VisitedCells visited(input.space.box, options.visit_cell > 0 ? options.visit_cell : input.space.spacing);
  const auto stride = static_cast<std::size_t>(options.visit_stride);
  double travel = 0, next = 0;
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    FrameRecord& frame = result.frames[k];
    if (k > 0) travel += (frame.at - result.frames[k - 1].at).norm();
    if (travel >= next) {
      frame.sampled = true;
      next = (std::floor(travel / step) + 1) * step;
    }
    if (visited.first(frame.at)) frame.first_visit = (visited.count() - 1) % stride == 0;
  }
}

void judge(FrameRecord& frame, const Vec3& reference, const Vec3& fresh, double floor) {
  const double scale = std::max(reference.norm(), floor);
  frame.reference = reference;
  frame.error = (frame.force - reference).norm() / scale;
  frame.approximation = (frame.undamped - reference).norm() / scale;
  frame.switching = (frame.force - frame.undamped).norm() / scale;
  frame.staleness = (frame.undamped - fresh).norm() / scale;
}

// Forces of models made anew at the sampled frames from all states known then. Touches nothing that labels change.
std::vector<Vec3> forces_of_all_known(const SessionInput& input, const SessionOptions& options, const SessionResult& result,
                                      const std::vector<std::size_t>& samples) {
  StateSpace space(input.space);
  SessionModel updater(space, options);
  std::vector<Vec3> forces(samples.size(), Vec3::Zero());
  std::size_t inserted = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const FrameRecord& frame = result.frames[samples[i]];
    for (; inserted < std::min<std::size_t>(frame.known, result.states.size()); ++inserted) space.insert(result.states[inserted]);
    updater.forget();   // no set of an earlier moment has a say
    if (!space.empty()) forces[i] = updater.model_at(frame.at).force(frame.at);
  }
  return forces;
}

}  // namespace

void analyse(const SessionInput& input, const SessionOptions& options, ReferenceService& references,
             SessionResult& result, const ShowProgress& show) {
  choose_samples(result, input, options);
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < result.frames.size(); ++k)
    if (result.frames[k].sampled || result.frames[k].first_visit) samples.push_back(k);
  for (const std::size_t k : samples) references.request(result.frames[k].at);   // solved while labels are made

  std::future<std::vector<Vec3>> fresh_forces =
      std::async(std::launch::async, [&] { return forces_of_all_known(input, options, result, samples); });
  StateSpace space(input.space);
  std::size_t inserted = 0, grown_at = 0;
  const auto total = static_cast<double>(result.frames.size());
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    FrameRecord& frame = result.frames[k];
    for (; inserted < std::min<std::size_t>(frame.known, result.states.size()); ++inserted) {
      space.insert(result.states[inserted]);
      grown_at = k;
    }
    const bool as_before = k > 0 && grown_at < k && frame.at == result.frames[k - 1].at;   // a hand at rest
    frame.label = as_before ? result.frames[k - 1].label : space.label(frame.at);
    if (show && k % 500 == 0) show({.t = static_cast<double>(k), .seconds = total, .known = inserted, .phase = "labels"});
  }
  const std::vector<Vec3> fresh = fresh_forces.get();
  std::size_t failed = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const State reference = references.get(result.frames[samples[i]].at);
    if (reference.usable())
      judge(result.frames[samples[i]], reference.force, fresh[i], options.error_floor);
    else
      ++failed;
    if (show)
      show({.t = static_cast<double>(i + 1), .seconds = static_cast<double>(samples.size()), .known = inserted,
            .phase = "references"});
  }
  if (failed > 0) result.notes.push_back(std::to_string(failed) + " reference solves failed: those samples have no error");

  // Published models become switches when the loop takes them.
  std::vector<SwitchRecord> taken;
  std::size_t published = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.took_model) continue;
    while (published < result.switches.size() && result.switches[published].model != frame.model) ++published;
    if (published == result.switches.size()) break;
    SwitchRecord record = result.switches[published++];
    record.t = frame.t;
    record.jump_undamped = frame.undamped_jump;
    taken.push_back(record);
  }
  result.switches = std::move(taken);
}

}  // namespace forefeel
