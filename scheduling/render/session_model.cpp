#include "scheduling/render/session_model.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "approx/model/lattice_field.hpp"
#include "approx/model/model_options.hpp"
#include "scheduling/common/option_check.hpp"

namespace forefeel {

namespace {
// With up to `few` states, their spacing cannot be estimated from the set. The first states are requested 2 to 4 h
// apart, so a spacing of 2 h is assumed. With a spacing of h, the force of a tangent would be held constant beyond 4 h,
// and only half the force would be rendered at the far end of a box.
constexpr std::size_t few = 3;
constexpr double apart_at_first = 2;  // spacings
constexpr double model_radius = 4;    // [spacings] radius around the HIP of the states in a lattice model
}  // namespace

void check(const SessionModelOptions& options) {
  detail::expect_option(detail::positive(options.update_travel), "update_travel",
                        fmt::format("is {}, expected spacings above 0", options.update_travel));
}

namespace {

ModelOptions at_first(ModelOptions options, const StateSpace& space) {
  options.neighbours = std::min(options.neighbours, uncapped_neighbours);  // of at most `few` states
  options.length = apart_at_first * space.options().spacing;
  return options;
}

}  // namespace

SessionModel::SessionModel(const StateSpace& space, const ModelRecipe& recipe)
    : space_(space),
      rbf_(space, recipe.fit),
      first_(space, at_first(recipe.fit, space)),
      with_stiffness_(recipe.fit.data == Data::force_and_stiffness),
      method_(recipe.method) {
  if (recipe.guess.isZero(0)) return;
  State rest;
  rest.force = Vec3::Zero();
  rest.stiffness = recipe.guess;
  StateSpace guessed(space.options());
  guessed.insert(rest);
  ModelOptions tangent = at_first(recipe.fit, space);
  tangent.data = Data::force_and_stiffness;
  tangent.kernel = Kernel::cubic;  // of one state: its tangent, whatever the kernel
  guess_ = std::make_unique<Guess>(std::move(guessed), tangent);
}

bool SessionModel::update_guess(const Vec3& hip, Model& out, UpdateReport* report) {
  if (!guess_) {
    draft_.clear();
    out.assign(draft_, 0);
    return false;
  }
  guess_->updater.update(hip, out, report, {.serial = ++serial_, .guess = true});
  if (report != nullptr) *report = {.label = Label::blank};
  return true;
}

bool SessionModel::update_lattice(const Vec3& hip, Model& out, UpdateReport* report) {
  const double spacing = space_.options().spacing;
  space_.within(hip, model_radius * spacing, near_.ids);
  if (near_.ids.empty()) space_.nearest(hip, 1, near_.ids);
  near_.states.clear();
  for (const StateId id : near_.ids) near_.states.push_back(space_[id]);
  const bool cubic = method_ == SessionMethod::tricubic;
  draft_.set_lattice(std::make_shared<const LatticeField>(near_.states, spacing, cubic), near_.ids);
  out.assign(draft_, ++serial_);
  if (report != nullptr)
    *report = {
        .n = near_.ids.size(), .replaced = near_.ids.size(), .refit = true, .label = space_.label(hip)};
  return true;
}

bool SessionModel::update(const Vec3& hip, Model& out, UpdateReport* report) {
  if (space_.empty()) return update_guess(hip, out, report);
  if (method_ != SessionMethod::rbf) return update_lattice(hip, out, report);
  ModelUpdater& updater = with_stiffness_ && space_.size() <= few ? first_ : rbf_;
  const bool known = updater.update(hip, out, report, {.serial = serial_ + 1});  // one count for both
  serial_ += known ? 1 : 0;
  return known;
}

Model SessionModel::model_at(const Vec3& hip) {
  Model model;
  update(hip, model);
  return model;
}

void SessionModel::forget() {
  rbf_.forget();
  first_.forget();
}

}  // namespace forefeel
