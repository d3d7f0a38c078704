// The exact formula against leaving every state out in turn, and the ridge it chooses.

#include "approx/error/leave_one_out.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<State> noisy_states(double noise, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-0.03, 0.03);
  std::normal_distribution<double> error(0, 1);
  std::vector<State> states;
  for (std::size_t i = 0; i < count; ++i) {
    states.push_back(field_state({unit(random), unit(random), unit(random)}));
    states.back().force += noise * Vec3(error(random), error(random), error(random));
  }
  return states;
}

struct Case {
  Kernel kernel;
  Data data;
  int power, degree;
};
const std::vector<Case> cases = {{Kernel::linear, Data::force, 1, 1},
                                 {Kernel::cubic, Data::force, 3, 1},
                                 {Kernel::quintic, Data::force, 5, 2},
                                 {Kernel::cubic, Data::force_and_stiffness, 3, 1},
                                 {Kernel::quintic, Data::force_and_stiffness, 5, 2}};

}  // namespace

TEST_CASE("Leave-one-out equals fitting without each state in turn, for every ridge") {
  const auto states = noisy_states(0.02, 24, 3);
  for (const auto& [kernel, data, power, degree] : cases)
    for (const double ridge : {0.0, 1e-6, 1e-2}) {
      CAPTURE(name(kernel), name(data), ridge);
      const auto missed = leave_one_out(states, {.kernel = kernel, .data = data, .ridge = ridge});
      REQUIRE(missed.size() == states.size());
      for (std::size_t i = 0; i < states.size(); ++i) {
        auto others = states;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
        const Judge judge(others, power, degree, data == Data::force_and_stiffness, ridge, states);
        const Vec3 expected = states[i].force - judge.force(states[i].at);
        CHECK((missed[i] - expected).norm() < 1e-7 * (1 + expected.norm()));
      }
    }
}

TEST_CASE("Without a ridge it equals this library's own models of the others") {
  const auto states = noisy_states(0.0, 30, 5);
  for (const auto& [kernel, data, power, degree] : cases) {
    CAPTURE(name(kernel), name(data));
    const auto missed = leave_one_out(states, {.kernel = kernel, .data = data});
    for (std::size_t i = 0; i < states.size(); ++i) {
      auto others = states;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const Model model = fit_model(others, {.kernel = kernel, .data = data}, states[i].at);
      if (model.force(states[i].at).norm() > 0.7 * model.force_bound()) continue;  // there it is bounded
      CHECK((states[i].force - model.force(states[i].at) - missed[i]).norm() < 1e-6);
    }
  }
}

TEST_CASE("The chosen ridge smooths noise and leaves exact states alone") {
  const auto rms = [](const StateSpace& space, ModelOptions options) {
    ModelUpdater updater(space, options);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(-0.02, 0.02);
    double sum = 0;
    for (int i = 0; i < 60; ++i) {
      const Vec3 x(unit(random), unit(random), unit(random));
      updater.forget();
      sum += (updater.model_at(x).force(x) - field_state(x).force).squaredNorm();
    }
    return std::sqrt(sum / 60);
  };
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic, Kernel::quintic}) {
    CAPTURE(name(kernel));
    StateSpaceOptions space_options;
    space_options.spacing = 0.006;
    StateSpace noisy(space_options), exact(space_options);
    for (const auto& s : noisy_states(0.05, 300, 7)) noisy.insert(s);
    for (const auto& s : noisy_states(0.0, 300, 7)) exact.insert(s);
    ModelOptions options{.kernel = kernel, .neighbours = 60};
    const RidgeChoice chosen = choose_ridge(noisy, options);
    CHECK(chosen.ridge > 0);
    CHECK(chosen.missed < chosen.unsmoothed);
    const double plain = rms(noisy, options);
    options.ridge = chosen.ridge;
    CHECK(rms(noisy, options) < (kernel == Kernel::linear ? 1.0 : 0.9) * plain);  // r itself smooths little
    options.ridge = 0;
    CHECK(choose_ridge(exact, options).missed <= choose_ridge(exact, options).unsmoothed);
    CHECK(choose_ridge(exact, options).ridge < 1e-2 * chosen.ridge);
  }
}

TEST_CASE("Too few states, or all in one place: nothing to leave out") {
  for (const std::size_t count : {0, 1, 3}) {
    const auto missed = leave_one_out(noisy_states(0, count, 2), {.kernel = Kernel::cubic});
    CHECK(missed.size() == count);
  }
  const std::vector<State> same(5, field_state({0.01, 0, 0}));
  for (const Vec3& miss : leave_one_out(same, {.kernel = Kernel::cubic})) CHECK(std::isnan(miss[0]));
  CHECK(choose_ridge(StateSpace({}), {}).ridge == 0);
}
