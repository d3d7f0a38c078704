#include "apps/laboratory/paper_states.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "geometry/coverage/setups.hpp"

namespace forefeel {

PaperStates::PaperStates(Laboratory& laboratory, std::size_t depth, const ShowShare& show, std::size_t gap)
    : h_(laboratory.spacing()),
      frame_(lattice_frame(laboratory.scene().inward)),
      depth_(static_cast<double>(depth)) {
  beyond_ =
      static_cast<int>(depth);  // not deeper: at 72 mm parts of a liver are crushed to 3 % of their volume
  gap_ = std::min(static_cast<int>(gap), beyond_ - 2);
  const Vec3 low = frame_ * (h_ * Vec3(-layers_, -half_width_, -half_width_));
  const Vec3 high = frame_ * (h_ * Vec3(beyond_, half_width_, half_width_));
  const Vec3 slack = Vec3::Constant(1e-6 * h_);
  box_ = {low.cwiseMin(high) - slack, low.cwiseMax(high) + slack};
  complete_ = laboratory.lattice_states(box_, h_, show);
  unsolved_ = lattice(box_, h_).size() - complete_.size();
}

std::string PaperStates::axis() const {
  Eigen::Index axis = 0;
  frame_.col(0).cwiseAbs().maxCoeff(&axis);
  return std::string(frame_(axis, 0) < 0 ? "-" : "+") + "xyz"[axis];
}

std::vector<State> PaperStates::known(std::string_view setup) const {
  SetupOptions options{.spacing = h_, .depth = layers_, .half_width = half_width_, .width = beyond_ * h_};
  if (setup == "gap") options.width = far_side();
  using Index = std::array<long, 3>;
  const auto index = [&](const Vec3& x) {
    return Index{std::lround(x[0] / h_), std::lround(x[1] / h_), std::lround(x[2] / h_)};
  };
  std::map<Index, const State*> solved;
  for (const State& state : complete_) solved.emplace(index(state.at), &state);
  std::vector<State> states;
  for (const Vec3& x :
       make_setup(setup, options).states)  // none if the second slab is deeper than our lattice
    if (const auto found = solved.find(index(frame_ * x)); found != solved.end())
      states.push_back(*found->second);
  return states;
}

StateSpace PaperStates::space(const std::vector<State>& known) const {
  StateSpaceOptions options;
  options.spacing = h_;
  options.box = box_;
  StateSpace space(options);
  for (const State& state : known) space.insert(state);
  return space;
}

namespace {

// The paper uses the sum at any distance from the states. With such a length between states, our model does the
// same (model_data.hpp).
ModelOptions nearest_100(Kernel kernel) {
  return {.kernel = kernel, .data = Data::force, .neighbours = 100, .select = Select::nearest, .length = 1e3};
}

}  // namespace

PathMethod linear_of_100() {
  return {"r, 100 nearest", "r", "r with the paper's settings", nearest_100(Kernel::linear)};
}

PathMethod cubic_of_100() {
  return {"r3, 100 nearest", "r3", "r3 with the paper's settings", nearest_100(Kernel::cubic)};
}

PathMethod our_default() {
  return {"Hermite r5, 25 by label",
          "Hermite r5",
          "Ours (Hermite r5, 25 states by label, extrapolation bounded, sides of the gap by their distances)",
          {.kernel = Kernel::quintic,
           .data = Data::force_and_stiffness,
           .neighbours = 25,
           .select = Select::label},
          true};
}

std::vector<PathMethod> paper_methods() {
  return {linear_of_100(), cubic_of_100(), our_default()};
}

}  // namespace forefeel
