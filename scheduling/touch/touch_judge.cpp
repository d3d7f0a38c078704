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

// Of the frames in touch, from `first` on.
void set_trust(const TouchSessionInput& input, const std::vector<std::shared_ptr<const DeepStates>>& models,
               std::span<TouchFrameRecord> frames) {
  constexpr double again = 0.001;  // [m]
  const double farthest = farthest_of(input.task.depth);
  const TouchFrameRecord* last = nullptr;
  SurfacePlace place;
  SiteModel model;
  for (TouchFrameRecord& frame : frames) {
    if (frame.touch == TouchKind::none || frame.source.model == 0) continue;
    if (last && last->source.model == frame.source.model && (last->tip - frame.tip).norm() < again) {
      frame.source.trusted = last->source.trusted, frame.source.estimate = last->source.estimate;
      continue;
    }
    if (place.facet != frame.site.facet || place.at != frame.site.at)
      place = frame.site, model = models[frame.source.model - 1]->model(place);
    const DeepStates& deep = *models[frame.source.model - 1];
    const Vec3 x = frame.tip - frame.site.at;
    if (x.norm() <= farthest) {
      frame.source.estimate = deep.estimated_error(model, place, x);
      frame.source.trusted = deep.trusted(model, place, x, input.task.tolerance, input.task.floor);
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

void judge(const TouchSessionInput& input, const TouchJudging& how, TouchSessionResult& result) {
  set_labels(input, result.states, result.frames);
  const std::size_t parts = 8, all = result.frames.size();
#pragma omp parallel for schedule(dynamic) num_threads(how.threads)
  for (std::size_t part = 0; part < parts; ++part)
    set_trust(
        input, result.models,
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
