#include "scheduling/render/bar_keeper.hpp"

#include <algorithm>
#include <cmath>

#include "approx/bar/prior_scores.hpp"

namespace forefeel {
namespace {

constexpr std::size_t remembered = 8192;  // frames: longer than nearly all solves take
constexpr std::size_t enough_audits = 20;
constexpr double other_weight = 0.05, other_reach = 1.5;  // [1], [spacings]

}  // namespace

BarKeeper::BarKeeper(const StateSpace& space, const Mat3& guess, LoopLink& link)
    : space_(space), link_(link), factors_({.prior = measured_prior()}), seen_(space.size()) {
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
    ++audits_[static_cast<std::size_t>(frame->label)];
    factors_.learn(frame->label, frame->score(state.force));
    return;
  }
  if (!model || newest_.scale.empty() || audits_[static_cast<std::size_t>(newest_.label)] >= enough_audits ||
      (state.at - hip_).norm() > other_reach * space_.options().spacing)
    return;
  const Vec3 predicted = model->force(state.at);
  factors_.learn(newest_.label, (predicted - state.force).norm() / newest_.scale.at(state.at, predicted),
                 other_weight);
}

void BarKeeper::publish(const Vec3& hip, const Model& model) {
  hip_ = hip;
  near_.clear();
  for (const StateId id : model.states()) near_.push_back(space_[id]);
  if (space_.empty() && guessed_.has_stiffness()) near_.push_back(guessed_);
  const std::size_t count = std::min(near_.size(), ErrorScale::most);
  std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(count), near_.end(),
                    [&](const State& a, const State& b) {
                      return (a.at - hip).squaredNorm() < (b.at - hip).squaredNorm();
                    });
  newest_.scale = ErrorScale(near_, space_.options().spacing);
  newest_.label = space_.empty() ? Label::blank : space_.label(hip, walk_);
  newest_.factors = factors_.factors(newest_.label);
  link_.bars.publish(newest_);
}

}  // namespace forefeel
