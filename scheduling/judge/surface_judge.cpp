#include "scheduling/judge/surface_judge.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "geometry/coverage/sited_labels.hpp"
#include "scheduling/judge/patience.hpp"
#include "scheduling/render/bar_link.hpp"

namespace forefeel {
namespace {

bool touches(const FrameRecord& frame) {
  return frame.touch.kind != TouchKind::none;
}

Vec3 displacement(const FrameRecord& frame) {
  return frame.at - frame.touch.site.at;
}

// Of all frames in touch, with the states known in each.
void set_labels(const TouchTask& task, const StateSpaceOptions& space, const std::vector<State>& states,
                std::vector<FrameRecord>& frames) {
  const RestSites& rest = task.field->rest();
  const std::size_t sites = task.field->size();
  std::vector<SitedState> all;
  for (std::size_t i = 0; i < sites; ++i) {
    const SurfacePlace& place = task.field->place(i);
    all.push_back({place.at, rest.pad().normal(place), Vec3::Zero()});
  }
  for (const State& state : states)
    all.push_back({state.site, rest.pad().normal(rest.map().nearest(state.site)), state.at});
  SitedLabels labels(std::move(all), space, task.depth, task.site_spacing());
  for (FrameRecord& frame : frames)
    if (touches(frame))
      frame.label =
          labels.at({frame.touch.site.at, frame.touch.normal, displacement(frame)}, sites + frame.known);
}

void set_bars(const SwitchOptions& jnd, const BarFactors& factors, FrameRecord& frame) {
  if (!std::isfinite(frame.bar.scale)) return;  // beyond the depth that is answered for
  const double held = (frame.elastic - frame.undamped).norm(), floor = bar_floor(frame.elastic, jnd);
  for (std::size_t level = 0; level < factors.size(); ++level)
    frame.bar.half_width[level] = std::max(floor, held + factors[level] * frame.bar.scale);
}

// Of the frames in touch.
void set_trust(const TouchTask& task, const SwitchOptions& jnd,
               const std::vector<std::shared_ptr<const DeepStates>>& models, std::span<FrameRecord> frames) {
  constexpr double again = 0.001;  // [m]
  const double farthest = farthest_of(task.depth);
  const FrameRecord* last = nullptr;
  SurfacePlace place;
  SiteModel model;
  std::uint32_t serial = 0;
  BarFactors factors{};
  for (FrameRecord& frame : frames) {
    const std::uint32_t now = frame.step.model;
    if (!touches(frame) || now == 0) continue;
    const DeepStates& deep = *models[now - 1];
    if (serial != now) factors = touch_bar_factors(deep.scores()), serial = now;
    if (last && last->step.model == now && (last->at - frame.at).norm() < again) {
      frame.bar = last->bar;
      set_bars(jnd, factors, frame);
      continue;
    }
    if (place != frame.touch.site) place = frame.touch.site, model = deep.model(place);
    const Vec3 x = displacement(frame);
    if (x.norm() <= farthest) {
      frame.bar.scale = deep.estimated_error(model, place, x);
      frame.bar.trusted = deep.trusted(model, place, x, task.tolerance, task.floor);
      set_bars(jnd, factors, frame);
    }
    last = &frame;
  }
}

void choose_samples(const TouchTask& task, double spacing, const JudgingOptions& judging,
                    std::vector<FrameRecord>& frames) {
  std::set<std::array<long, 6>> visited;
  const double cell = visit_cell(judging, spacing);
  double way = judging.reference_step;
  Vec3 before = Vec3::Zero();
  bool touched = false;
  std::size_t visits = 0;
  for (FrameRecord& frame : frames) {
    if (!touches(frame)) {
      touched = false;
      continue;
    }
    if (touched) way += (frame.at - before).norm();
    before = frame.at, touched = true;
    if (way >= judging.reference_step) frame.judged.sampled = true, way = 0;
    std::array<long, 6> key{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      key[i] = std::lround(frame.at[k] / cell),
      key[i + 3] = std::lround(frame.touch.site.at[k] / task.site_spacing());
    }
    if (!visited.insert(key).second) continue;
    frame.judged.first_visit = visits++ % static_cast<std::size_t>(judging.visit_stride) == 0;
  }
}

void set_error(const Vec3& reference, double floor, bool viscous, FrameRecord& frame) {
  Judgement& judged = frame.judged;
  const double scale = std::max(reference.norm(), floor);
  judged.reference = reference;
  if (viscous) judged.elastic_reference = reference;
  judged.error = (frame.elastic - reference).norm() / scale;
  judged.approximation = (frame.undamped - reference).norm() / scale;
  judged.switching = (frame.elastic - frame.undamped).norm() / scale;
}

void set_errors(const JudgeSetup& setup, ReferenceService& references, SessionResult& result,
                const ShowProgress& show) {
  std::vector<FrameRecord*> wanted;
  for (FrameRecord& frame : result.frames)
    if (frame.judged.sampled || frame.judged.first_visit) wanted.push_back(&frame);
  for (const FrameRecord* frame : wanted) references.request(displacement(*frame), frame->touch.site);
  Patience patience(setup.stop);
  std::size_t failed = 0, late = 0, done = 0;
  for (FrameRecord* frame : wanted) {
    const std::optional<State> state =
        patience.wait_for(displacement(*frame), references, result.interrupted(), frame->touch.site);
    if (!state)
      ++late;
    else if (state->usable())
      set_error(state->force, setup.judging.error_floor, !setup.viscosity.empty(), *frame);
    else
      ++failed;
    if (show)
      show({.phase = SessionPhase::references,
            .t = static_cast<double>(++done),
            .seconds = static_cast<double>(wanted.size()),
            .known = result.states.size()});
  }
  note_missing(failed, late, wanted.size(), result);
}

}  // namespace

void judge_surface(const SurfaceModels& models, const JudgeSetup& setup, const StateSpaceOptions& space,
                   ReferenceService& references, int threads, SessionResult& result,
                   const ShowProgress& show) {
  const TouchTask& task = models.task();
  set_labels(task, space, result.states, result.frames);
  const std::vector<std::shared_ptr<const DeepStates>> all = models.all();
  const std::size_t parts = 8, frames = result.frames.size();
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t part = 0; part < parts; ++part)
    set_trust(task, setup.jnd, all,
              std::span(result.frames)
                  .subspan(part * frames / parts, (part + 1) * frames / parts - part * frames / parts));
  if (setup.errors) {
    choose_samples(task, space.spacing, setup.judging, result.frames);
    set_errors(setup, references, result, show);
  }
  keep_taken(result);
}

}  // namespace forefeel
