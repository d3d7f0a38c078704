#include "apps/commands/generate_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "approx/model/model_options.hpp"
#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/placement/placement.hpp"

namespace forefeel {
namespace {

nlohmann::ordered_json to_json(const ErrorQuantiles& q) {
  nlohmann::ordered_json object;
  object["p50"] = number(q.p50);
  object["p95"] = number(q.p95);
  object["max"] = number(q.max);
  return object;
}

nlohmann::ordered_json to_json(const PlacementReport& report, double error) {
  nlohmann::ordered_json document;
  document["states"] = report.states;
  document["most_states"] = report.most_states;
  document["solved"] = report.solved;
  document["failed"] = report.failed;
  document["resumed"] = report.resumed;
  document["seconds"] = number(report.seconds);
  document["threads"] = report.threads;
  document["error"] = error;
  document["error_estimate"] = number(report.estimate.held());  // the least E that the estimate stays below
  document["error_estimate_quantiles"] = to_json(report.estimate);
  nlohmann::ordered_json truth = to_json(report.truth);
  truth["held"] = number(report.truth.held());
  truth["samples"] = report.truth_samples;
  truth["on_surface"] = report.truth_on_surface;
  truth["failed"] = report.truth_failed;
  truth["unsolved"] = report.truth_unsolved;
  truth["fresh"] = report.truth_is_fresh;
  document["error_true"] = truth;
  document["linear"] = report.linear;
  document["estimate_holds"] = report.estimate_holds;
  document["truth_holds"] = report.truth_holds;
  if (report.truth_unsolved > 0 || report.truth_samples == 0) document["truth_holds"] = nullptr;  // unknown
  document["interrupted"] = report.stopped;
  return document;
}

std::string in_words(const ErrorQuantiles& q) {
  return fmt::format("p50 {:.2g} %, p95 {:.2g} %, max {:.2g} %", 100 * q.p50, 100 * q.p95, 100 * q.max);
}

std::string in_words(const PlacementProgress& p) {
  if (p.truth_total > 0)
    return fmt::format("{} states, truth {} of {}", p.states, p.truth_done, p.truth_total);
  const std::string states = fmt::format("{} of at most {} states", p.states, p.most_states);
  return std::isfinite(p.estimate) ? fmt::format("{}, estimated error {:.3g} %", states, 100 * p.estimate)
                                   : states;
}

// Progress in [0, 1] that never decreases: the larger of two shares. The first uses the logarithm of the
// error, because the error about halves in each round. The second is the share of the allowed number of
// states.
class Share {
 public:
  explicit Share(double error) : error_(error) {}
  double operator()(const PlacementProgress& p) {
    if (first_ == 0 && std::isfinite(p.estimate)) first_ = p.estimate;
    if (first_ > error_ && p.estimate > 0)
      most_ = std::max(most_, std::log(first_ / p.estimate) / std::log(first_ / error_));
    if (p.most_states > 0)
      most_ = std::max(most_, static_cast<double>(p.states) / static_cast<double>(p.most_states));
    return most_ = std::clamp(most_, 0.0, 1.0);
  }

 private:
  double error_, first_ = 0, most_ = 0;
};

// Why the result is incomplete; empty if it is complete.
std::string complaint(const PlacementReport& report, double error, const StateSpaceOptions& space) {
  if (report.stopped) return "interrupted; rerun the same command to resume";
  if (!report.estimate_holds && report.states >= report.most_states) {
    // Rest and the eight corners of the box are tried on any lattice.
    const std::size_t positions = lattice(space.box, space.spacing).size();
    const std::string why =
        positions >= report.most_states
            ? fmt::format("as many as the lattice of {:g} m has positions in the box", space.spacing)
            : fmt::format("the fewest that are tried, for the lattice of {:g} m has {} in the box",
                          space.spacing,
                          positions == 0   ? "no position"
                          : positions == 1 ? "1 position"
                                           : fmt::format("{} positions", positions));
    return fmt::format(
        "{} states, {}, hold an estimated error of {:.3g}, not {:.3g}: the spacing is the limit; reduce it",
        report.states, why, report.estimate.held(), error);
  }
  if (!report.estimate_holds)
    return fmt::format("{} states hold an estimated error of {:.3g}, not {:.3g}; {} solves failed",
                       report.states, report.estimate.held(), error, report.failed);
  if (!report.truth_holds)
    return fmt::format("the true error of {:.3g} at {} positions is above {:.3g}", report.truth.held(),
                       report.truth_samples + report.truth_on_surface, error);
  return {};
}

}  // namespace

void check_generate_to_error(const Scene& scene) {
  try {
    for_states(scene.model, lattice(scene.space.box, scene.space.spacing).size());
  } catch (const InputError& error) {
    throw InputError({.file = scene.file.string(), .key = error.place().key}, error.problem());
  }
}

int generate_to_error(const Globals& globals, const Scene& scene, StateFile file, const std::string& output,
                      double error) {
  PlacementOptions options;
  options.error = error;
  options.space = scene.space;
  options.estimate.model = scene.model;
  options.estimate.floor = scene.session.judging.error_floor;
  options.seed = globals.seed;
  options.threads = globals.threads;
  options.want_displacements = scene.displacements;
  std::stop_source stop;
  options.stop = stop.get_token();

  std::optional<Progress> progress(std::in_place, globals, "generate");
  Share share(error);
  std::optional<InterruptWatch> watch(std::in_place);
  const PlacementReport report = place_states(
      scene.body, options, file.read_all(), [&](State state) { file.append(std::span(&state, 1)); },
      [&](const PlacementProgress& p) {
        if (watch->raised()) stop.request_stop();
        progress->show(share(p), in_words(p));
      });
  watch.reset();
  progress.reset();

  if (globals.json) print_json(to_json(report, error));
  say(globals, fmt::format("{}: {} states, {} solved in {:.2f} s, {} there before, {} failed{}", output,
                           report.states, report.solved, report.seconds, report.resumed, report.failed,
                           report.linear ? "; linear: three solves give the whole state space" : ""));
  say(globals, fmt::format("error estimated over the box: {}", in_words(report.estimate)));
  if (report.truth_samples > 0)
    say(globals,
        fmt::format(
            "true error at {} random positions, the largest also at {} on the faces of the box: {}{}{}",
            report.truth_samples, report.truth_on_surface, in_words(report.truth),
            report.truth_is_fresh ? "" : " (some of them became states)",
            report.truth_unsolved > 0 ? fmt::format("; {} were left unsolved", report.truth_unsolved) : ""));
  const std::string why = complaint(report, error, scene.space);
  if (why.empty()) return 0;
  warn(globals, why);
  return 1;
}

}  // namespace forefeel
