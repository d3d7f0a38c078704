#include "scheduling/touch/touch_judge.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>

#include "geometry/coverage/state_space.hpp"

namespace forefeel {
namespace {

Mat3 turned(const Vec3& from, const Vec3& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

// The states near one site, in its frame.
class LabelsAt {
 public:
  LabelsAt(const TouchSessionInput& input, const std::vector<State>& states)
      : input_(input), states_(states) {
    for (const State& state : states) {
      const SurfacePlace place = input.task.field->rest().map().nearest(state.site);
      normals_.push_back(input.task.field->rest().pad().normal(place));
    }
    for (std::size_t i = 0; i < input.task.field->size(); ++i)
      rest_normals_.push_back(input.task.field->rest().pad().normal(input.task.field->place(i)));
  }

  Label at(const TouchFrameRecord& frame) {
    if (!space_ || known_ != frame.source.known ||
        (site_ - frame.site.at).norm() > 0.25 * input_.site_spacing)
      gather(frame);
    return space_->label(turned(frame.normal, normal_) * (frame.tip - frame.site.at));
  }

 private:
  void gather(const TouchFrameRecord& frame) {
    StateSpaceOptions options = input_.task.tips;
    const double reach = input_.task.depth;
    options.box = {Vec3::Constant(-reach), Vec3::Constant(reach)};
    space_.emplace(options);
    known_ = frame.source.known, site_ = frame.site.at, normal_ = frame.normal;
    const auto put = [&](const Vec3& site, const Vec3& normal, const Vec3& x) {
      if (!((site - site_).norm() <= input_.site_spacing) || !(normal.dot(normal_) >= 0.5)) return;
      State state;
      state.at = turned(normal, normal_) * x;
      space_->insert(std::move(state));
    };
    for (std::size_t i = 0; i < input_.task.field->size(); ++i)
      put(input_.task.field->place(i).at, rest_normals_[i], Vec3::Zero());
    for (std::size_t i = 0; i < std::min<std::size_t>(known_, states_.size()); ++i)
      put(states_[i].site, normals_[i], states_[i].at);
  }

  const TouchSessionInput& input_;
  const std::vector<State>& states_;
  std::vector<Vec3> normals_, rest_normals_;
  std::optional<StateSpace> space_;
  std::uint32_t known_ = 0;
  Vec3 site_ = Vec3::Zero(), normal_ = Vec3::Zero();
};

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
      place = frame.site, model = input.task.field->at(place, false);
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

void judge(const TouchSessionInput& input, const TouchJudging& how, TouchSessionResult& result) {
  LabelsAt labels(input, result.states);
  for (TouchFrameRecord& frame : result.frames)
    if (frame.touch != TouchKind::none) frame.label = labels.at(frame);
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
