#include "apps/laboratory/speed_bound.hpp"

#include <cmath>
#include <functional>
#include <map>

#include "apps/study/study_speed.hpp"
#include "scheduling/judge/visited_cells.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/record/exact_rendering.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/render/session_model.hpp"
#include "solver/body/contact_stiffness.hpp"

namespace forefeel {
namespace {

ExactRendering rendering_at(double speed, double t0, const StudyPlan& plan, const StudyCell& cell,
                            ReferenceService& references, const std::function<Vec3(const Vec3&)>& guess) {
  const Scene& scene = plan.scenes[cell.scene];
  const SessionOptions& options = cell.options;
  const auto device =
      make_device(device_at_speed(options.motion.device, speed, {.file = plan.study.file.string()}),
                  {.box = scene.space.box,
                   .inward = scene.inward,
                   .seed = options.seed,
                   .folder = scene.file.parent_path()});
  const double seconds = plan.study.sustained->travel / speed;
  const auto frames = static_cast<std::size_t>(std::llround(seconds / options.clock.frame));
  VisitedCells visited(scene.space.box, visit_cell(options.judging, scene.space.spacing));
  std::vector<Vec3> motion;
  std::vector<std::size_t> visits;
  for (std::size_t k = 0; k < frames; ++k) {
    motion.push_back(device->position(frame_time(k, options.clock.frame), Vec3::Zero()));
    if (!visited.first(motion.back()) ||
        (visited.count() - 1) % static_cast<std::size_t>(options.judging.visit_stride) != 0)
      continue;
    visits.push_back(k);
    references.request(motion.back());
  }
  const auto exact = [&](const Vec3& x) {
    const State state = references.get(x);
    return state.usable() ? state.force : Vec3::Constant(unknown);
  };
  return render_exact(motion, visits, t0, options.switching, plan.study.sustained->tolerance, exact, guess);
}

}  // namespace

SpeedBound speed_bound(const StudyPlan& plan, const StudyCell& cell, ReferenceService& references,
                       bool first_guess) {
  const Scene& scene = plan.scenes[cell.scene];
  const auto cost =
      make_cost(cell.options.workers.cost, cell.seed, [&] { return references.recorded_costs(); });
  const double t0 = first_possible(*cost, scene.space, cell.options.workers.latency, true);
  const StateSpace nothing(scene.space);
  SessionModel model(nothing, {.fit = cell.options.model.fit,
                               .method = cell.options.model.method,
                               .guess = first_guess ? disc_stiffness(*scene.body) : Mat3(Mat3::Zero())});
  const auto guess = [&](const Vec3& x) { return model.model_at(x).force(x); };
  std::map<double, ExactRendering> seen;
  const SustainedSpeed found = sustained_speed(*plan.study.sustained, [&](double speed) {
    return (seen[speed] = rendering_at(speed, t0, plan, cell, references, guess)).share();
  });
  const ExactRendering& at_best = found.speed > 0 ? seen.at(found.speed) : seen.begin()->second;
  return {.known = at_best.known, .speed = found.speed, .settled_after = at_best.settled - at_best.known};
}

}  // namespace forefeel
