#include "scheduling/render/bar_keeper.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr std::size_t remembered = 8192;  // frames: longer than nearly all solves take
constexpr std::size_t enough_audits = 20;
// Of the calibration: step of a_t, and the scores that the prior counts as.
constexpr double step = 0.02, prior_weight = 60;
// A guess alone says nothing of how the stiffness changes: its errors on a block were up to 1.8 times the usual bar.
constexpr double of_guess = 2;
// The scale is estimated from as many departures as there are states. Its bars are wider by Student's t of one degree
// of freedom fewer, over that of the normal distribution (97.5 %). One state shows no departure: bars of its tangent
// would have had to be 16 times as wide to hold 90 %.
double of_few(std::size_t states) {
  constexpr std::array wider{10.0, 6.48, 2.20, 1.62, 1.42, 1.31, 1.25, 1.21};  // of 1, 2, ... states
  return states > wider.size() ? 1 + 1.5 / static_cast<double>(states)
                               : wider[std::max<std::size_t>(states, 1) - 1];
}

}  // namespace

BarKeeper::BarKeeper(const StateSpace& space, const Mat3& guess, LoopLink& link)
    : space_(space),
      link_(link),
      factors_({.gamma = step, .prior_weight = prior_weight, .prior = grasp_prior()}),
      seen_(space.size()) {
  rendered_.reserve(remembered);
  if (guess.isZero(0)) return;
  guessed_.force = Vec3::Zero();
  guessed_.stiffness = guess;
}

const RenderedFrame* BarKeeper::rendered_at(const Vec3& x) const {
  const auto found = std::ranges::find(rendered_, x, &RenderedFrame::at);
  return found == rendered_.end() ? nullptr : &*found;
}

void BarKeeper::learn(const Model* model) {
  while (const auto frame = link_.rendered.pop()) {
    if (rendered_.size() < remembered)
      rendered_.push_back(*frame);
    else
      rendered_[next_] = *frame;
    next_ = (next_ + 1) % remembered;
  }
  for (; seen_ < space_.size(); ++seen_)
    learn_from(space_[StateId{static_cast<std::uint32_t>(seen_)}], model);
}

void BarKeeper::learn_from(const State& state, const Model* model) {
  if (guessed_.has_stiffness() && state.at.isZero(0)) return;
  if (const RenderedFrame* frame = rendered_at(state.at)) {
    if (!std::isfinite(frame->scale)) return;
    ++audits_[frame->label];
    for (const Label label : all_labels)
      if (label == frame->label || audits_[label] < enough_audits)
        factors_.learn(label, frame->score(state.force));
    return;
  }
  if (!model || newest_.scale.empty()) return;
  const Vec3 predicted = model->force(state.at);
  const double scale = model->has_jets() ? model->at({state.at}).error
                                         : newest_.scale.at(state.at, predicted) / newest_.scale.stretched();
  level_.learn((predicted - state.force).norm() / scale);
}

void BarKeeper::publish(const Vec3& hip, const Model& model) {
  near_.clear();
  for (const StateId id : model.states()) near_.push_back(space_[id]);
  const bool guess_alone = space_.empty() && guessed_.has_stiffness();
  if (guess_alone) near_.push_back(guessed_);
  const std::size_t count = std::min(near_.size(), ErrorScale::most);
  std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(count), near_.end(),
                    [&](const State& a, const State& b) {
                      return (a.at - hip).squaredNorm() < (b.at - hip).squaredNorm();
                    });
  newest_.scale = ErrorScale(near_, space_.options().spacing);
  const double wider = guess_alone ? of_guess : model.has_jets() ? 1 : of_few(space_.size());
  newest_.scale.stretch(wider * level_.stretch());
  newest_.label = space_.empty() ? Label::blank : space_.label(hip, walk_);
  newest_.factors = factors_.factors(newest_.label);
  link_.bars.publish(newest_);
}

}  // namespace forefeel
