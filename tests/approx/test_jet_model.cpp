// Models of energy jets against fields whose Taylor series are exact: sums of sines and polynomials of degree 5.

#include "approx/model/jet_set.hpp"
#include "geometry/states/energy_jet.hpp"
#include "tests/approx/loop_energy.hpp"
#include "tests/approx/sets.hpp"
#include "tests/support/test.hpp"

namespace {

double factorial(int n) {
  return n < 2 ? 1 : n * factorial(n - 1);
}

// W(x) = 1/2 x . C x + sum_j c_j g(a_j . x), with the derivatives of g given: g(s) = sin s - s, or s^5 + s^4.
class Field {
 public:
  explicit Field(bool polynomial) : polynomial_(polynomial) {
    for (Wave& w : waves_) w.along *= polynomial ? 0.3 : 1;
  }

  double energy(const Vec3& x) const {
    double sum = 0.5 * x.dot(bend_ * x);
    for (const Wave& w : waves_) sum += w.size * derivative(0, w.along.dot(x));
    return sum;
  }
  Vec3 force(const Vec3& x) const {
    Vec3 f = -bend_ * x;
    for (const Wave& w : waves_) f -= w.size * derivative(1, w.along.dot(x)) * w.along;
    return f;
  }
  State state(const Vec3& x, int order = 4) const {
    State s;
    s.at = x;
    s.force = force(x);
    s.energy = energy(x);
    s.stiffness = bend_;
    for (const Wave& w : waves_)
      s.stiffness += w.size * derivative(2, w.along.dot(x)) * w.along * w.along.transpose();
    auto jet = std::make_shared<EnergyJet>();
    jet->order = order;
    for (int degree = 3; degree <= order + 1; ++degree)
      for (int a = degree; a >= 0; --a)
        for (int b = degree - a; b >= 0; --b) {
          const int c = degree - a - b;
          double sum = 0;
          for (const Wave& w : waves_)
            sum += w.size * derivative(degree, w.along.dot(x)) * std::pow(w.along[0], a) *
                   std::pow(w.along[1], b) * std::pow(w.along[2], c);
          jet->coefficients[jet_index(a, b, c)] = sum / (factorial(a) * factorial(b) * factorial(c));
        }
    s.jet = jet;
    s.solve.status = SolveStatus::converged;
    return s;
  }

 private:
  struct Wave {
    double size;
    Vec3 along;  // [1/m]
  };
  double derivative(int k, double s) const {
    if (polynomial_)
      return (k > 5 ? 0 : factorial(5) / factorial(5 - k) * std::pow(s, 5 - k)) +
             (k > 4 ? 0 : factorial(4) / factorial(4 - k) * std::pow(s, 4 - k));
    const double sine = k % 4 == 0   ? std::sin(s)
                        : k % 4 == 1 ? std::cos(s)
                        : k % 4 == 2 ? -std::sin(s)
                                     : -std::cos(s);
    return sine - (k == 0 ? s : k == 1 ? 1 : 0);
  }

  bool polynomial_;
  Mat3 bend_ = Vec3(90, 120, 200).asDiagonal();
  std::array<Wave, 3> waves_{{{0.02, Vec3(25, 10, -5)}, {0.015, Vec3(-8, 30, 12)}, {0.03, Vec3(6, -4, 22)}}};
};

ModelOptions of_jets(std::size_t neighbours = 8) {
  return {.data = Data::jet, .neighbours = neighbours};
}

StateSpace space_of(const std::vector<State>& states) {
  StateSpace space({.spacing = 0.006});
  for (const State& s : states) space.insert(s);
  return space;
}

std::vector<State> states_of(const Field& field, const std::vector<Vec3>& at) {
  std::vector<State> states;
  for (const Vec3& x : at) states.push_back(field.state(x));
  return states;
}

}  // namespace

TEST_CASE("Jets of a polynomial of degree five are the polynomial, blended or alone", "[jets]") {
  const Field field(true);
  for (const std::size_t count : {1u, 3u, 9u, 20u}) {
    CAPTURE(count);
    const Model model = fit_model(states_of(field, random_points(count, 0.02, 1)), of_jets(20), Vec3::Zero());
    REQUIRE(model.has_jets());
    REQUIRE(model.states().size() == count);
    for (const Vec3& x : random_points(50, 0.03, 2))
      CHECK((model.force(x) - field.force(x)).norm() < 1e-10 * field.force(x).norm());
  }
}

TEST_CASE("The error of one jet falls as its order says", "[jets]") {
  const Field field(false);
  for (const int order : {2, 3, 4}) {
    CAPTURE(order);
    const Model model =
        fit_model(std::vector{field.state(Vec3(0.002, -0.001, 0.003), order)}, of_jets(), Vec3::Zero());
    const auto error = [&](double r) {
      double sum = 0;
      for (const Vec3& u : random_points(40, 1, 3)) {
        const Vec3 x = Vec3(0.002, -0.001, 0.003) + r * u.normalized();
        sum += (model.force(x) - field.force(x)).squaredNorm();
      }
      return std::sqrt(sum);
    };
    CHECK(std::log2(error(0.002) / error(0.001)) == Approx(order + 1).margin(0.2));
  }
}

TEST_CASE("A blend of jets is exact at its states, is a potential, and its stiffness is its derivative",
          "[jets]") {
  const Field field(false);
  const std::vector<State> states = states_of(field, random_points(12, 0.03, 4));
  const Model model = fit_model(states, of_jets(12), Vec3::Zero());
  for (const State& s : states) {
    Vec3 force;
    Mat3 jacobian;
    model.evaluate(s.at, force, jacobian);
    CHECK((force - s.force).norm() < 1e-9 * s.force.norm());
    CHECK((jacobian + s.stiffness).norm() < 1e-6 * s.stiffness.norm());
  }
  for (const Vec3& x : random_points(100, 0.05, 5)) {
    Vec3 force;
    Mat3 jacobian;
    model.evaluate(x, force, jacobian);
    CHECK((force - model.force(x)).norm() <= 1e-14 * force.norm());
    CHECK((jacobian - jacobian.transpose()).norm() < 1e-11 * jacobian.norm());
    Mat3 differences;
    const double step = 1e-5;
    for (int d = 0; d < 3; ++d) {
      const Vec3 e = step * Vec3::Unit(d);
      differences.col(d) = (8 * (model.force(x + e) - model.force(x - e)) -
                            (model.force(x + 2 * e) - model.force(x - 2 * e))) /
                           (12 * step);
    }
    CHECK((jacobian - differences).norm() < 1e-6 * jacobian.norm());
  }
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto drawn = [&](double size) { return Vec3(size * Vec3(unit(random), unit(random), unit(random))); };
  for (int k = 0; k < 100; ++k) {
    const auto loop = ellipse(drawn(0.02), drawn(0.015), drawn(0.015), 4000);
    CHECK(loop_energy(loop, [&](const Vec3& x) { return model.force(x); }).ratio() < 1e-6);
  }
}

TEST_CASE("Beyond the radius of its jets a model stays bounded and smooth", "[jets]") {
  const Field field(false);
  const Model model = fit_model(std::vector{field.state(Vec3::Zero())}, of_jets(), Vec3::Zero());
  for (const Vec3& u : random_points(40, 1, 7)) {
    Vec3 before = model.force(Vec3::Zero());
    for (double r = 0; r < 0.6; r += 0.001) {
      Vec3 force;
      Mat3 jacobian;
      const Vec3 x = r * u.normalized();
      model.evaluate(x, force, jacobian);
      CHECK(force.norm() <= model.force_bound());
      const double step = 1e-6;
      const Vec3 along =
          (model.force(x + step * u.normalized()) - model.force(x - step * u.normalized())) / (2 * step);
      CAPTURE(r, model.trust_distance(), model.hold_distance(), model.force_bound(), force.norm());
      CHECK((along - jacobian * u.normalized()).norm() < 1e-3 * (1 + jacobian.norm()));
      CHECK((force - before).norm() < 0.5);  // [N], over 1 mm
      before = force;
    }
  }
  CHECK(model.force(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())).allFinite());
}

TEST_CASE("A surprise lowers the trust of the jets that made it, whatever the order of the states",
          "[jets]") {
  const Field field(false);
  std::vector<State> states = states_of(field, random_points(7, 0.02, 8));
  states.push_back(field.state(Vec3(0.012, 0.012, 0.012)));
  states.back().force *= 1.5;  // on another branch
  std::vector<std::array<double, 3>> trusts;
  std::mt19937 random(9);
  for (int order = 0; order < 5; ++order) {
    const StateSpace space = space_of(states);
    JetSet jets(space, of_jets());
    jets.learn();
    std::vector<std::array<double, 3>> now;
    for (std::uint32_t i = 0; i < space.size(); ++i) {
      const JetSet::Trust t = jets.trust(StateId{i});
      const double to_other = (space[StateId{i}].at - states.back().at).norm();
      if (order == 0 && i + 1 < space.size()) {
        CHECK(t.surprised == Approx(to_other));
        CHECK(t.distance <= 0.8 * to_other * (1 + 1e-12));
      }
      now.push_back({space[StateId{i}].at.x(), t.distance, t.confirmed});
    }
    std::ranges::sort(now);
    if (order == 0) trusts = now;
    CHECK(now == trusts);
    std::ranges::shuffle(states.begin(), states.end() - 1, random);
  }
  // Without the other branch all confirm each other.
  const StateSpace space = space_of(states_of(field, random_points(7, 0.02, 8)));
  JetSet jets(space, of_jets());
  jets.learn();
  for (std::uint32_t i = 0; i < space.size(); ++i) CHECK(std::isinf(jets.trust(StateId{i}).surprised));
}

TEST_CASE("What a model of jets says of itself", "[jets]") {
  const Field field(false);
  State rest = field.state(Vec3::Zero());
  auto limited = std::make_shared<EnergyJet>(*rest.jet);
  limited->limit = 0.01;
  rest.jet = limited;
  const Model alone = fit_model(std::vector{rest}, of_jets(), Vec3::Zero());
  CHECK(alone.at({Vec3(0.004, 0, 0)}).trusted);
  CHECK_FALSE(alone.at({Vec3(0.012, 0, 0)}).trusted);  // beyond the material limit, nothing confirmed
  const Model confirmed =
      fit_model(std::vector{rest, field.state(Vec3(0.013, 0, 0))}, of_jets(1), Vec3::Zero());
  CHECK(confirmed.at({Vec3(0.012, 0, 0)}).trusted);
  std::size_t below = 0, all = 0;
  for (const Vec3& x : random_points(300, 0.009, 10)) {
    const Answer found = alone.at({x});
    if (!(x.norm() < 0.01)) continue;
    ++all;
    below += (found.force - field.force(x)).norm() <= found.error;
  }
  CHECK(all > 100);
  CHECK(below >= 0.9 * static_cast<double>(all));
  CHECK(std::isnan(fit_model(states_at(lattice_points(1, 0.006)), {.neighbours = 27}, Vec3::Zero())
                       .at({Vec3::Zero()})
                       .error));
}

TEST_CASE("States without jets make the model of force and stiffness", "[jets]") {
  const std::vector<State> states = states_at(lattice_points(2, 0.006));
  const StateSpace space = space_of(states);
  ModelOptions hermite{.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};
  ModelOptions jets = hermite;
  jets.data = Data::jet;
  ModelUpdater a(space, hermite), b(space, jets);
  for (const Vec3& x : random_points(20, 0.02, 11)) {
    const Model with = a.model_at(x), without = b.model_at(x);
    CHECK_FALSE(without.has_jets());
    CHECK(with.force(x) == without.force(x));
  }
}

TEST_CASE("Jets of another branch stay out of a blend", "[jets]") {
  const Field field(false);
  std::vector<State> states = states_of(field, random_points(6, 0.008, 12));
  State other = field.state(Vec3(0.004, 0.002, -0.003));
  other.energy -= 0.01;  // [J]: the equilibrium of a fold, with about the same force
  states.push_back(other);
  const StateSpace space = space_of(states);
  JetSet jets(space, of_jets());
  jets.learn();
  std::vector<StateId> chosen;
  jets.choose(Vec3(-0.004, 0, 0.002), chosen);
  CHECK(chosen.size() == 6);
  CHECK(std::ranges::find(chosen, StateId{6}) == chosen.end());
  jets.choose(other.at, chosen);
  CHECK(chosen == std::vector<StateId>{StateId{6}});
  // A blend of the two would push with the difference of the energies.
  ModelUpdater updater(space, of_jets());
  double worst = 0;
  for (const Vec3& x : random_points(100, 0.008, 13))
    worst = std::max(worst, (updater.model_at(x).force(x) - field.force(x)).norm());
  CHECK(worst < 0.01);  // [N]
}

TEST_CASE("Beyond its trust an estimate is at least the error that was seen there", "[jets]") {
  const Field field(false);
  State other = field.state(Vec3(0.012, 0, 0));
  other.force *= 1.5;
  other.jet = nullptr;
  const StateSpace space = space_of({field.state(Vec3::Zero()), other});
  const Model model = ModelUpdater(space, of_jets()).model_at(Vec3::Zero());
  const Answer there = model.at({other.at});
  CHECK_FALSE(there.trusted);
  CHECK(there.error >= 0.999 * (there.force - other.force).norm());
  CHECK(model.at({Vec3(0.006, 0, 0)}).error < 1e-3);
}

TEST_CASE("Where no jet reaches the neighbours' data answer", "[jets]") {
  const Field field(false);
  std::vector<State> states = states_of(field, random_points(30, 0.02, 14));
  for (State& s : states) {
    auto wild = std::make_shared<EnergyJet>(*s.jet);
    for (double& c : wild->coefficients) c *= 1e10;  // as beside folds: it ends within 0.1 mm
    s.jet = wild;
  }
  const StateSpace wild = space_of(states);
  JetSet jets(wild, of_jets());
  jets.learn();
  CHECK(jets.empty());
  ModelOptions hermite{.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};
  ModelUpdater a(wild, hermite), b(wild, [&] {
    ModelOptions options = hermite;
    options.data = Data::jet;
    return options;
  }());
  for (const Vec3& x : random_points(20, 0.02, 15)) CHECK(a.model_at(x).force(x) == b.model_at(x).force(x));
  // One that reaches 5 mm answers there and nowhere else.
  states.push_back(field.state(Vec3(0.03, 0, 0)));
  auto short_of_it = std::make_shared<EnergyJet>(*states.back().jet);
  short_of_it->coefficients[jet_index(5, 0, 0)] = 1.5 / (5 * std::pow(0.005, 4));
  short_of_it->coefficients[jet_index(0, 5, 0)] = short_of_it->coefficients[jet_index(0, 0, 5)] =
      short_of_it->coefficients[jet_index(5, 0, 0)];
  states.back().jet = short_of_it;
  const StateSpace space = space_of(states);
  ModelUpdater updater(space, of_jets());
  CHECK(updater.model_at(Vec3(0.031, 0, 0)).has_jets());
  CHECK_FALSE(updater.model_at(Vec3(-0.01, 0, 0)).has_jets());
}
