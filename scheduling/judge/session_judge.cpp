#include "scheduling/judge/session_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "geometry/index/path_walk.hpp"
#include "scheduling/judge/patience.hpp"
#include "scheduling/judge/visited_cells.hpp"
#include "scheduling/render/session_model.hpp"

namespace forefeel {

namespace {

Mat3 stiffness_of(const State& state) {
  return state.has_stiffness() ? state.stiffness : Mat3::Zero();
}

Vec3 tangent(const State& state, const Vec3& x) {
  return state.force - stiffness_of(state) * (x - state.at);
}

Vec3 between(const State& a, const State& b, double s, const Vec3& x) {
  const Vec3 chord = b.at - a.at, off = x - (a.at + s * chord);
  if (!a.has_stiffness() || !b.has_stiffness()) return (1 - s) * a.force + s * b.force;
  const Vec3 from = -(a.stiffness * chord), to = -(b.stiffness * chord);
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * a.force + s * s * (1 + 2 * r) * b.force + s * r * r * from - s * s * r * to -
         (r * a.stiffness + s * b.stiffness) * off;
}

}  // namespace

std::vector<Vec3> viscous_reference(std::span<const FrameRecord> frames,
                                    std::span<const SampledState> samples, const Viscosity& viscosity) {
  if (samples.empty()) return {};
  std::vector<double> travel(frames.size(), 0);
  for (std::size_t k = 1; k < frames.size(); ++k)
    travel[k] = travel[k - 1] + (frames[k].at - frames[k - 1].at).norm();
  RelaxationFilter filter(viscosity);
  std::vector<Vec3> forces;
  std::size_t next = 0;  // the first sample at or after the frame
  for (std::size_t k = 0; k < frames.size(); ++k) {
    while (next < samples.size() && samples[next].frame < k) ++next;
    const Vec3& x = frames[k].at;
    Vec3 elastic;
    if (next == 0 || next == samples.size()) {
      elastic = tangent(samples[std::min(next, samples.size() - 1)].state, x);
    } else {
      const SampledState &a = samples[next - 1], &b = samples[next];
      const double whole = travel[b.frame] - travel[a.frame];
      elastic = between(a.state, b.state, whole > 0 ? (travel[k] - travel[a.frame]) / whole : 1, x);
    }
    forces.push_back(filter.step(elastic, k > 0 ? frames[k].t - frames[k - 1].t : 0));
  }
  return forces;
}

namespace {

void judge(FrameRecord& frame, const Vec3& reference, const Vec3& fresh, double floor) {
  const double scale = std::max(reference.norm(), floor);
  Judgement& judged = frame.judged;
  judged.reference = reference;
  judged.error = (frame.force - reference).norm() / scale;
  judged.approximation = (frame.undamped - reference).norm() / scale;
  judged.switching = (frame.elastic - frame.undamped).norm() / scale;
  judged.staleness = (frame.undamped - fresh).norm() / scale;
}

// The error of a viscous body: the reference passes the same filter as the rendered force.
void judge_viscous(std::span<const SampledState> samples, const Viscosity& viscosity, double floor,
                   std::vector<FrameRecord>& frames) {
  const std::vector<Vec3> forces = viscous_reference(frames, samples, viscosity);
  for (const SampledState& sample : samples) {
    const Vec3& force = forces[sample.frame];
    Judgement& judged = frames[sample.frame].judged;
    judged.elastic_reference = judged.reference;
    judged.reference = force;
    judged.error = (frames[sample.frame].force - force).norm() / std::max(force.norm(), floor);
  }
}

// Selects the sampled frames: by arc length, and every visit_stride-th first visit of a lattice cell. The
// cells are cubes of side visit_cell with corners in the box.
class Samples {
 public:
  Samples(const StateSpaceOptions& space, const JudgingOptions& options)
      : visited_(space.box, visit_cell(options, space.spacing)),
        step_(options.reference_step),
        stride_(static_cast<std::size_t>(options.visit_stride)) {}

  struct Choice {
    bool sampled = false, first_visit = false;
  };
  Choice next(const Vec3& at) {
    Choice choice;
    if (begun_) travel_ += (at - last_).norm();
    begun_ = true;
    last_ = at;
    if (travel_ >= next_) {
      choice.sampled = true;
      next_ = (std::floor(travel_ / step_) + 1) * step_;
    }
    if (visited_.first(at)) choice.first_visit = (visited_.count() - 1) % stride_ == 0;
    return choice;
  }

 private:
  VisitedCells visited_;
  double step_, travel_ = 0, next_ = 0;
  std::size_t stride_;
  bool begun_ = false;
  Vec3 last_ = Vec3::Zero();
};

}  // namespace

void keep_taken(SessionResult& result) {
  std::vector<SwitchRecord> taken;
  std::size_t published = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.step.took_model) continue;
    while (published < result.switches.size() && result.switches[published].model != frame.step.model)
      ++published;
    if (published == result.switches.size()) break;
    SwitchRecord record = result.switches[published++];
    record.t = frame.t;
    record.jump_undamped = frame.step.undamped_jump;
    taken.push_back(record);
  }
  result.switches = std::move(taken);
}

void note_missing(std::size_t failed, std::size_t late, std::size_t all, SessionResult& result) {
  if (late > 0) {
    if (result.run.end == RunEnd::whole) result.run.end = RunEnd::interrupted;
    result.notes.push_back(fmt::format(
        "interrupted: {} of {} references were not waited for, those samples have no error", late, all));
  }
  if (failed > 0)
    result.notes.push_back(std::to_string(failed) + " reference solves failed: those samples have no error");
}

struct SessionJudge::Impl {
  struct Found {
    Label label;
    Samples::Choice choice;
    Vec3 fresh;  // of a sample: force of a model made anew from all states known then [N]
  };

  Impl(const JudgeSetup& given, const StateSpace& all, ReferenceService& service)
      : setup(given),
        references(service),
        patience(given.stop),
        samples(all.options(), given.judging),
        known(all),
        model(all, given.model) {}

  std::vector<std::size_t> enter_labels(SessionResult& result) const;
  void enter_errors(const std::vector<std::size_t>& chosen, SessionResult& result, const ShowProgress& show);

  const JudgeSetup setup;
  ReferenceService& references;
  Patience patience;
  Samples samples;
  const StateSpace& known;
  SessionModel model;
  PathWalk walk;
  Vec3 last = Vec3::Zero();
  std::vector<Found> found;  // by frame
};

SessionJudge::SessionJudge(const JudgeSetup& setup, const StateSpace& known, ReferenceService& references)
    : impl_(std::make_unique<Impl>(setup, known, references)) {}
SessionJudge::~SessionJudge() = default;

void SessionJudge::frame(const PassedFrame& frame) {
  Impl& my = *impl_;
  const bool as_before = !my.found.empty() && !frame.grown && frame.at == my.last;  // a hand at rest
  my.last = frame.at;
  Impl::Found result{.label = as_before ? my.found.back().label : my.known.label(frame.at, my.walk),
                     .choice = my.setup.errors ? my.samples.next(frame.at) : Samples::Choice{},
                     .fresh = Vec3::Zero()};
  if (result.choice.sampled || result.choice.first_visit) {
    my.references.request(frame.at);
    my.model.forget();  // earlier neighbour sets must not affect this model
    result.fresh = my.model.model_at(frame.at).force(frame.at);
  }
  my.found.push_back(result);
}

// Labels of all frames, and which are samples. Returns the samples.
std::vector<std::size_t> SessionJudge::Impl::enter_labels(SessionResult& result) const {
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    FrameRecord& frame = result.frames[k];
    frame.label = found[k].label;
    frame.judged.sampled = found[k].choice.sampled;
    frame.judged.first_visit = found[k].choice.first_visit;
    if (frame.judged.sampled || frame.judged.first_visit) chosen.push_back(k);
  }
  return chosen;
}

void SessionJudge::Impl::enter_errors(const std::vector<std::size_t>& chosen, SessionResult& result,
                                      const ShowProgress& show) {
  const double floor = setup.judging.error_floor;  // f0 [N]
  const Viscosity& viscosity = setup.viscosity;
  std::size_t failed = 0, late = 0;
  std::vector<SampledState> samples_known;  // of a viscous body
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    FrameRecord& frame = result.frames[chosen[i]];
    const std::optional<State> reference = patience.wait_for(frame.at, references, result.interrupted());
    if (!reference)
      ++late;
    else if (reference->usable())
      judge(frame, reference->force, found[chosen[i]].fresh, floor);
    else
      ++failed;
    if (!viscosity.empty() && reference && reference->usable())
      samples_known.push_back({chosen[i], *reference});
    if (show)
      show({.phase = SessionPhase::references,
            .t = static_cast<double>(i + 1),
            .seconds = static_cast<double>(chosen.size()),
            .known = result.states.size()});
  }
  if (!viscosity.empty()) judge_viscous(samples_known, viscosity, floor, result.frames);
  note_missing(failed, late, chosen.size(), result);
}

void SessionJudge::finish(SessionResult& result, const ShowProgress& show) {
  impl_->enter_errors(impl_->enter_labels(result), result, show);
  keep_taken(result);
}

}  // namespace forefeel
