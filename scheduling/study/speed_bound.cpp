#include "scheduling/study/speed_bound.hpp"

#include <cmath>
#include <functional>
#include <map>

#include "scheduling/judge/visited_cells.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/record/exact_rendering.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/render/session_model.hpp"
#include "scheduling/study/sustained_speed.hpp"
#include "solver/equilibrium/first_guess.hpp"

namespace forefeel {
namespace {

ExactRendering rendering_at(double speed, double t0, const SustainedOptions& sought,
                            const SessionOptions& options, const SessionInput& input,
                            ReferenceService& references, const std::function<Vec3(const Vec3&)>& guess) {
  const auto device = make_device(device_at_speed(options.motion.device, speed, "study.sustained"),
                                  {.box = input.touched.space.box,
                                   .inward = input.touched.inward,
                                   .seed = options.seed,
                                   .folder = input.files.scene});
  const double seconds = sought.travel / speed;
  const auto frames = static_cast<std::size_t>(std::llround(seconds / options.clock.frame));
  VisitedCells visited(input.touched.space.box, visit_cell(options.judging, input.touched.space.spacing));
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
  return render_exact(motion, visits, t0, options.switching, sought.tolerance, exact, guess);
}

}  // namespace

SpeedBound speed_bound(const SustainedOptions& sought, const StudyCell& cell, const SessionInput& input,
                       ReferenceService& references, bool first_guess) {
  const auto cost =
      make_cost(cell.options.workers.cost, {.seed = cell.seed}, [&] { return references.recorded_costs(); });
  const double t0 = first_possible(*cost, input.touched.space, cell.options.workers.latency, true);
  const StateSpace nothing(input.touched.space);
  SessionModel model(nothing, {.fit = cell.options.model.fit,
                               .method = cell.options.model.method,
                               .guess = first_guess ? forefeel::first_guess(input.touched.body).stiffness
                                                    : Mat3(Mat3::Zero())});
  const auto guess = [&](const Vec3& x) { return model.model_at(x).force(x); };
  std::map<double, ExactRendering> seen;
  const SustainedSpeed found = sustained_speed(sought, [&](double speed) {
    return (seen[speed] = rendering_at(speed, t0, sought, cell.options, input, references, guess)).share();
  });
  const ExactRendering& at_best = found.speed > 0 ? seen.at(found.speed) : seen.begin()->second;
  return {.known = at_best.known, .speed = found.speed, .settled_after = at_best.settled - at_best.known};
}

}  // namespace forefeel
