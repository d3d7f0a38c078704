#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "scheduling/record/needed_states.hpp"
#include "scheduling/record/run_files.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// Nearest-rank quantile of sorted values; unknown when there are none.
double quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return unknown;
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

Json timing(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  return {{"p50", number(quantile(values, 0.5))},
          {"p99", number(quantile(values, 0.99))},
          {"max", number(quantile(values, 1))}};
}

double jnd(const Vec3& force, const SwitchOptions& options) {
  return std::max(options.jnd_share * force.norm(), options.jnd_floor);
}

template <class Choose>
Json errors(const SessionResult& result, const SwitchOptions& options, bool with_max, Choose choose) {
  std::vector<double> sorted;
  std::size_t within = 0;
  for (const FrameRecord& f : result.frames) {
    if (!std::isfinite(f.error) || !choose(f)) continue;
    sorted.push_back(f.error);
    within += (f.force - f.reference).norm() <= jnd(f.reference, options);
  }
  std::sort(sorted.begin(), sorted.end());
  Json json{{"samples", sorted.size()},
            {"p50", number(quantile(sorted, 0.5))},
            {"p95", number(quantile(sorted, 0.95))}};
  if (with_max) json["max"] = number(quantile(sorted, 1));
  json["within_jnd"] =
      number(sorted.empty() ? unknown : static_cast<double>(within) / static_cast<double>(sorted.size()));
  return json;
}

Json error_json(const SessionResult& result, const SwitchOptions& options) {
  const auto sampled = [](const FrameRecord& f) { return f.sampled; };
  Json json{{"reference", "tight solves on the reference branch"}};
  json.update(errors(result, options, true, sampled));
  Json parts, medians;
  const std::pair<const char*, double FrameRecord::*> columns[] = {
      {"approximation", &FrameRecord::approximation},
      {"switch", &FrameRecord::switching},
      {"staleness", &FrameRecord::staleness}};
  for (const auto& [key, member] : columns) {
    std::vector<double> sorted;
    for (const FrameRecord& f : result.frames)
      if (f.sampled && std::isfinite(f.*member)) sorted.push_back(f.*member);
    std::sort(sorted.begin(), sorted.end());
    parts[key] = number(quantile(sorted, 0.95));
    medians[key] = number(quantile(sorted, 0.5));
  }
  json["parts"] = parts;
  json["parts_p50"] = medians;
  Json by_label;
  for (const Label label : {Label::safe, Label::sparse, Label::gap, Label::blank})
    by_label[std::string(name(label))] = errors(
        result, options, true, [label](const FrameRecord& f) { return f.sampled && f.label == label; });
  json["by_label"] = by_label;
  json["first_visit"] = errors(result, options, false, [](const FrameRecord& f) { return f.first_visit; });
  return json;
}

Json deadline_json(const SessionResult& result, const SessionOptions& options) {
  std::size_t missed = 0;
  std::vector<double> cost, lateness;
  for (const FrameRecord& f : result.frames) {
    cost.push_back(f.cost_us);
    lateness.push_back(f.lateness_us);
    missed += f.cost_us + f.lateness_us > options.frame * 1e6;
  }
  return {
      {"missed", missed}, {"cost_us", timing(std::move(cost))}, {"lateness_us", timing(std::move(lateness))}};
}

Json states_json(const SessionResult& result) {
  std::size_t used = 0;
  std::vector<double> age;
  for (const DispatchRecord& d : result.dispatch) {
    if ((d.status != "solved" && d.status != "arrived") || !std::isfinite(d.first_used)) continue;
    ++used;
    age.push_back(1e3 * (d.first_used - d.finished));
  }
  std::sort(age.begin(), age.end());
  const auto [start, solved, failed] = result.start_solved_failed;
  return {{"start", start},
          {"solved", solved},
          {"used", used},
          {"wasted", solved - std::min(used, solved)},
          {"preempted", result.preempted},
          {"failed", failed},
          {"age_at_use_ms", {{"p50", number(quantile(age, 0.5))}, {"p99", number(quantile(age, 0.99))}}}};
}

// Largest |sum of dF| within any window of given length.
double drift(const SessionResult& result, double window) {
  std::vector<Vec3> sum(result.frames.size() + 1, Vec3::Zero());
  for (std::size_t k = 0; k < result.frames.size(); ++k) sum[k + 1] = sum[k] + result.frames[k].switch_delta;
  if (result.frames.size() < 2) return 0;
  const double frame = result.frames[1].t - result.frames[0].t;
  const auto width =
      std::min(result.frames.size(), static_cast<std::size_t>(std::max(1LL, std::llround(window / frame))));
  double most = 0;
  for (std::size_t k = 0; k + width < sum.size(); ++k)
    most = std::max(most, (sum[k + width] - sum[k]).norm());
  return most;
}

Json switch_json(const SessionResult& result, const SessionOptions& options) {
  double jump = 0, undamped = 0;
  std::size_t over = 0;
  for (const FrameRecord& f : result.frames) {
    jump = std::max(jump, f.switch_change);
    undamped = std::max(undamped, f.undamped_jump);
    over += f.switch_change > f.switch_bound;
  }
  return {{"count", result.switches.size()},
          {"rule", name(options.switching.rule)},
          {"max_jump", jump},
          {"max_jump_undamped", undamped},
          {"frames_over_jnd", over},
          {"drift",
           {{"ms50", drift(result, 0.05)}, {"ms100", drift(result, 0.1)}, {"ms300", drift(result, 0.3)}}}};
}

// States needed per second of motion, those known at the start left out, over states solved per second by the workers
// when all are busy: a job takes its worker the solves and a message each way.
double load(const SessionResult& result, const SessionInput& input, const SessionOptions& options) {
  const double h = options.visit_cell > 0 ? options.visit_cell : input.space.spacing;
  NeededStates needed(input.space.box, h);
  for (std::size_t i = 0; i < result.start_solved_failed[0]; ++i) needed.know(result.states[i].at);
  for (const FrameRecord& f : result.frames) needed.visit(f.at);
  if (result.frames.empty() || result.solve_seconds.empty() || result.workers == 0) return unknown;
  const double seconds = result.frames.back().t + (result.frames.size() > 1 ? result.frames[1].t : 0);
  const double messages =
      options.clock == Clock::virtual_time ? 2 * options.latency * static_cast<double>(result.jobs) : 0;
  const double total = std::accumulate(result.solve_seconds.begin(), result.solve_seconds.end(), messages);
  const double rate = result.workers * static_cast<double>(result.solve_seconds.size()) / total;
  return static_cast<double>(needed.count()) / seconds / rate;
}

}  // namespace

Json summary_json(const SessionResult& result, const SessionInput& input, const SessionOptions& options) {
  std::size_t in[4] = {0, 0, 0, 0};
  for (const FrameRecord& f : result.frames) ++in[static_cast<std::size_t>(f.label)];
  Json time_in;
  for (const Label label : {Label::safe, Label::sparse, Label::gap, Label::blank})
    time_in[std::string(name(label))] = static_cast<double>(in[static_cast<std::size_t>(label)]) /
                                        static_cast<double>(std::max<std::size_t>(1, result.frames.size()));
  Json json;
  json["clock"] = options.clock == Clock::real ? "real" : "virtual";
  const bool whole = static_cast<double>(result.frames.size()) > options.seconds / options.frame - 0.75;
  json["seconds"] = whole ? options.seconds : static_cast<double>(result.frames.size()) * options.frame;
  json["frames"] = result.frames.size();
  json["deadline"] = deadline_json(result, options);
  json["states"] = states_json(result);
  json["time_in"] = time_in;
  json["switch"] = switch_json(result, options);
  json["error"] = error_json(result, options.switching);
  json["load"] = number(load(result, input, options));
  json["energy"] = {{"generated_J", number(result.generated_energy)}, {"work_J", number(result.work)}};
  json["safety"] = {{"clamped", result.clamped},
                    {"slewed", result.slewed},
                    {"stale", result.stale},
                    {"non_finite", result.non_finite}};
  json["workers"] = options.workers;
  json["policy"] = options.policy;
  json["select"] = name(options.model.select);
  json["seed"] = options.seed;
  json["device"] = options.replay ? "replay:" + options.replay->string() : options.device;
  json["first_guess"] = !result.switches.empty() && result.switches.front().cause == "guess";
  json["wall_seconds"] = result.wall_seconds;
  json["realtime_priority"] = result.realtime_priority;
  json["memory_locked"] = result.memory_locked;
  json["notes"] = result.notes;
  return json;
}

}  // namespace forefeel
