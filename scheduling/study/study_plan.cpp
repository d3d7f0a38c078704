#include "scheduling/study/study_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/record/needed_states.hpp"

namespace forefeel {

StudyCell make_cell(const Study& study, std::size_t combination, std::uint64_t seed,
                    const SessionOptions& options) {
  StudyCell cell{.choice = study.choice(combination), .seed = seed, .input = combination, .options = options};
  cell.options.clock.kind = Clock::virtual_time;
  cell.options.workers.threads = 1;
  cell.options.seed = seed;
  if (const auto speed = number_at(study, cell.choice, "speed"))
    cell.options.motion.device = device_at_speed(cell.options.motion.device, *speed, "study.speed");
  if (study.sustained) device_at_speed(cell.options.motion.device, 1, "study.sustained");  // refuses others
  return cell;
}

void check_cell(const Study& study, const SessionInput& input, StudyCell& cell) {
  if (cell.options.planning.arrivals)
    for (const auto& [key, given] :
         {std::pair{"study.sustained", study.sustained.has_value()},
          std::pair{"study.target_load", find_axis(study, "target_load").has_value()}})
      if (given)
        throw InputError(
            key,
            "has no effect where states arrive at given times (session.arrivals), since nothing is "
            "solved; expected one or the other");
  if (!study.sustained) {
    SessionOptions options = cell.options;
    if (options.clock.length != RunLength::motion) options.clock.length = RunLength::shorter;
    const SessionPlan plan = make_plan(input, options);
    cell.notes = plan.motion_notes;
    cell.options.clock.seconds = plan.options.clock.seconds;
    cell.motion_seconds = plan.device->duration();
    return;
  }
  SessionOptions options = cell.options;
  for (const double speed : {study.sustained->low, study.sustained->high}) {
    options.motion.device = device_at_speed(cell.options.motion.device, speed, "study.sustained");
    options.clock.seconds = study.sustained->travel / speed;
    make_plan(input, options);
  }
}

void set_cost(const Study& study, const SessionInput& input, StudyCell& cell) {
  const std::optional<double> load = number_at(study, cell.choice, "target_load");
  if (!load) return;
  const double demand = states_needed_per_second(input, cell.options);
  if (demand <= 0)
    throw InputError("study.target_load",
                     fmt::format("device '{}' needs no state of the box, expected a motion through it",
                                 to_text(cell.options.motion.device)));
  cell.options.workers.cost = cost_for_load(*load, cell.options, demand);
  if (!std::holds_alternative<HandMotion>(cell.options.motion.device.motion())) return;
  cell.load_to_find = *load;
  cell.free_demand = demand;
}

StudyPlan plan_study(const Study& study, const StudySessions& sessions) {
  StudyPlan plan{.study = study, .inputs = {}, .cells = {}};
  for (std::size_t c = 0; c < study.combinations(); ++c) {
    StudySession session = sessions(study.choice(c));
    for (const std::uint64_t seed : study.seeds) {
      StudyCell cell = make_cell(study, c, seed, session.options);
      check_cell(study, session.input, cell);
      set_cost(study, session.input, cell);
      plan.cells.push_back(std::move(cell));
    }
    plan.inputs.push_back(std::move(session.input));
  }
  return plan;
}

double states_needed_per_second(const SessionInput& input, const SessionOptions& options) {
  const auto device = make_device(options.motion.device, {.box = input.touched.space.box,
                                                          .inward = input.touched.inward,
                                                          .seed = options.seed,
                                                          .folder = input.files.scene});
  const double h = visit_cell(options.judging, input.touched.space.spacing);
  const auto frames = static_cast<std::size_t>(std::llround(options.clock.seconds / options.clock.frame));
  NeededStates needed(input.touched.space.box, h);
  if (options.planning.rest_known) needed.know(Vec3::Zero());
  for (std::size_t k = 0; k < frames; ++k)
    needed.visit(device->position(static_cast<double>(k) * options.clock.frame, Vec3::Zero()));
  return static_cast<double>(needed.count()) / options.clock.seconds;
}

CostSpec cost_for_load(double load, const SessionOptions& options, double demand) {
  const double sigma =
      std::log(10.0) / (2 * 1.959964);  // 95 % within a factor of ten, as the paper's 0.1 to 1 s
  const double batch = std::max(options.planning.batch, 1);
  const double job = load * options.workers.count * batch / demand;
  const double mean = (job - 2 * options.workers.latency) / (1 + (batch - 1) * options.workers.batch_share);
  if (!(mean > 0))
    throw InputError(
        "study.target_load",
        fmt::format("holds {}, but a message of {} s each way alone makes the load {:.3g}; expected more",
                    load, options.workers.latency,
                    2 * options.workers.latency * demand / (options.workers.count * batch)));
  if (mean > 1e6)
    throw InputError(
        "study.target_load",
        fmt::format("holds {}, for which a solve takes {:.3g} s; expected a load of at most {:.3g}", load,
                    mean, load * 1e6 / mean));
  return LogNormalCost{.median = mean * std::exp(-0.5 * sigma * sigma), .sigma = sigma};
}

DeviceSpec device_at_speed(const DeviceSpec& device, double speed, const std::string& where) {
  const PathMotion* path = std::get_if<PathMotion>(&device.motion());
  if (!path)
    throw InputError(where,
                     fmt::format("device '{}' has no speed to set, expected path:NAME", to_text(device)));
  if (path->speed)
    throw InputError(where,
                     fmt::format("device '{}' names its speed already, expected it once", to_text(device)));
  PathMotion faster = *path;
  faster.speed = speed;
  return {faster, fmt::format("{},speed={}", to_text(device), speed)};
}

}  // namespace forefeel
