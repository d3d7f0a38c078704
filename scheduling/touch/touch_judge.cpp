#include "scheduling/touch/touch_judge.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "geometry/coverage/sited_labels.hpp"

namespace forefeel {
namespace {

// Of all frames in touch, with the states known in each.
void set_labels(const TouchSessionInput& input, const std::vector<State>& states,
                std::vector<TouchFrameRecord>& frames) {
  const RestSites& rest = input.task.field->rest();
  const std::size_t sites = input.task.field->size();
  std::vector<SitedState> all;
  for (std::size_t i = 0; i < sites; ++i) {
    const SurfacePlace& place = input.task.field->place(i);
    all.push_back({place.at, rest.pad().normal(place), Vec3::Zero()});
  }
  for (const State& state : states)
    all.push_back({state.site, rest.pad().normal(rest.map().nearest(state.site)), state.at});
  SitedLabels labels(std::move(all), input.task.tips, input.task.depth, input.site_spacing);
  for (TouchFrameRecord& frame : frames)
    if (frame.touch != TouchKind::none)
      frame.label =
          labels.at({frame.site.at, frame.normal, frame.tip - frame.site.at}, sites + frame.source.known);
}

// |F - f| over the estimate: quantiles over the 1,400 samples above the floor of 25 sessions whose bodies, laws,
// motions and costs of a solve were drawn at random; tests/bench/error_bar_prior.py draws others and checks the bars.
constexpr std::array<double, 40> prior_scores{0.066, 0.066, 0.076, 0.096, 0.12, 0.14, 0.17, 0.19, 0.22, 0.24,
                                              0.26,  0.29,  0.31,  0.34,  0.37, 0.39, 0.42, 0.45, 0.48, 0.51,
                                              0.55,  0.59,  0.63,  0.67,  0.71, 0.76, 0.81, 0.86, 0.93, 1,
                                              1.1,   1.2,   1.3,   1.5,   1.7,  1.9,  2.3,  2.9,  4.1,  6.4};

}  // namespace

double touch_bar_floor(const TouchFrameRecord& frame, const SwitchOptions& jnd) {
  constexpr double finest = 0.1;  // of the JND
  return finest * std::max(jnd.jnd_share * frame.force.elastic.norm(), jnd.jnd_floor);
}

namespace {

void set_bars(const SwitchOptions& jnd, const std::array<double, 3>& factors, TouchFrameRecord& frame) {
  if (!std::isfinite(frame.source.bar.scale)) return;  // beyond the depth that is answered for
  const double held = (frame.force.elastic - frame.force.undamped).norm(),
               floor = touch_bar_floor(frame, jnd);
  for (std::size_t level = 0; level < factors.size(); ++level)
    frame.source.bar.half_width[level] = std::max(floor, held + factors[level] * frame.source.bar.scale);
}

// Of the frames in touch.
void set_trust(const TouchSessionInput& input, const SwitchOptions& jnd,
               const std::vector<std::shared_ptr<const DeepStates>>& models,
               std::span<TouchFrameRecord> frames) {
  constexpr double again = 0.001;  // [m]
  const double farthest = farthest_of(input.task.depth);
  const TouchFrameRecord* last = nullptr;
  SurfacePlace place;
  SiteModel model;
  std::uint32_t serial = 0;
  std::array<double, 3> factors{};
  for (TouchFrameRecord& frame : frames) {
    if (frame.touch == TouchKind::none || frame.source.model == 0) continue;
    if (serial != frame.source.model)
      factors = touch_bar_factors(models[frame.source.model - 1]->scores()), serial = frame.source.model;
    if (last && last->source.model == frame.source.model && (last->tip - frame.tip).norm() < again) {
      frame.source.bar = last->source.bar;
      set_bars(jnd, factors, frame);
      continue;
    }
    if (place.facet != frame.site.facet || place.at != frame.site.at)
      place = frame.site, model = models[frame.source.model - 1]->model(place);
    const DeepStates& deep = *models[frame.source.model - 1];
    const Vec3 x = frame.tip - frame.site.at;
    if (x.norm() <= farthest) {
      frame.source.bar.scale = deep.estimated_error(model, place, x);
      frame.source.bar.trusted = deep.trusted(model, place, x, input.task.tolerance, input.task.floor);
      set_bars(jnd, factors, frame);
    }
    last = &frame;
  }
}

void choose_samples(const TouchSessionInput& input, const JudgingOptions& judging,
                    std::vector<TouchFrameRecord>& frames) {
  std::set<std::array<long, 6>> visited;
  const double cell = visit_cell(judging, input.task.tips.spacing);
  double way = judging.reference_step;
  Vec3 before = Vec3::Zero();
  bool touched = false;
  std::size_t visits = 0;
  for (TouchFrameRecord& frame : frames) {
    if (frame.touch == TouchKind::none) {
      touched = false;
      continue;
    }
    if (touched) way += (frame.tip - before).norm();
    before = frame.tip, touched = true;
    if (way >= judging.reference_step) frame.judged.sampled = true, way = 0;
    std::array<long, 6> key{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      key[i] = std::lround(frame.tip[k] / cell),
      key[i + 3] = std::lround(frame.site.at[k] / input.site_spacing);
    }
    if (!visited.insert(key).second) continue;
    frame.judged.first_visit = visits++ % static_cast<std::size_t>(judging.visit_stride) == 0;
  }
}

}  // namespace

bool is_within_jnd(const TouchFrameRecord& frame, const SwitchOptions& jnd) {
  const Vec3& reference = frame.judged.reference;
  return (frame.force.elastic - reference).norm() <=
         std::max(jnd.jnd_share * reference.norm(), jnd.jnd_floor);
}

std::array<double, 3> touch_bar_factors(const std::vector<double>& scores) {
  std::vector<double> all(prior_scores.begin(), prior_scores.end());
  all.insert(all.end(), scores.begin(), scores.end());
  std::ranges::sort(all);
  std::array<double, 3> factors{};
  constexpr std::array levels{0.90, 0.95, 0.99};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double rank = std::ceil(levels[i] * static_cast<double>(all.size() + 1)) - 1;
    factors[i] = all[std::min(all.size() - 1, static_cast<std::size_t>(rank))];
  }
  return factors;
}

void judge(const TouchSessionInput& input, const TouchJudging& how, TouchSessionResult& result) {
  set_labels(input, result.states, result.frames);
  const std::size_t parts = 8, all = result.frames.size();
#pragma omp parallel for schedule(dynamic) num_threads(how.threads)
  for (std::size_t part = 0; part < parts; ++part)
    set_trust(
        input, how.jnd, result.models,
        std::span(result.frames).subspan(part * all / parts, (part + 1) * all / parts - part * all / parts));
  choose_samples(input, how.judging, result.frames);
  std::vector<TouchFrameRecord*> wanted;
  for (TouchFrameRecord& frame : result.frames)
    if (frame.judged.sampled || frame.judged.first_visit) wanted.push_back(&frame);
  std::size_t done = 0;
#pragma omp parallel num_threads(how.threads)
  {
    TouchSolver solver(input.task.field->rest_shared(), input.task.tips.spacing);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (how.stop.is_interrupted()) continue;
      TouchFrameRecord& frame = *wanted[i];
      const State state = solver.reference(frame.site, frame.tip - frame.site.at);
#pragma omp critical
      {
        ++done;
        if (state.usable()) {
          frame.judged.reference = state.force;
          const double scale = std::max(state.force.norm(), how.judging.error_floor);
          frame.judged.error = (frame.force.elastic - state.force).norm() / scale;
          frame.judged.approximation = (frame.force.undamped - state.force).norm() / scale;
          frame.judged.switching = (frame.force.elastic - frame.force.undamped).norm() / scale;
        } else {
          ++result.references_failed;
        }
        if (how.progress)
          how.progress({.done = static_cast<double>(done),
                        .whole = static_cast<double>(wanted.size()),
                        .references = true,
                        .known = result.states.size()});
      }
    }
  }
  if (done < wanted.size()) result.interrupted = true;
}

}  // namespace forefeel
