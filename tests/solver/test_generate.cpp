#include <set>
#include <stdexcept>

#include "block_body.hpp"
#include "geometry/coverage/state_space.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/sweep_plan.hpp"
#include "tests/support/test.hpp"

namespace {

LatticeOptions small_box(int threads) {
  LatticeOptions options;
  options.spacing = 0.006;
  options.box = {Vec3(-0.018, -0.013, -0.012), Vec3(0.024, 0.013, 0.018)};  // odd and even ends
  options.threads = threads;
  return options;
}

std::map<std::array<long, 3>, State> generate(const std::shared_ptr<const Body>& body,
                                              const LatticeOptions& options,
                                              const std::vector<State>& known = {},
                                              GenerateReport* report = nullptr) {
  std::map<std::array<long, 3>, State> states;
  const auto keep = [&](State s) {
    const std::array<long, 3> k{std::lround(s.at[0] / 0.006), std::lround(s.at[1] / 0.006),
                                std::lround(s.at[2] / 0.006)};
    CHECK(states.emplace(k, std::move(s)).second);
  };
  const GenerateReport result = generate_lattice(body, options, keep, {}, known);
  if (report) *report = result;
  return states;
}

bool same_bits(const State& a, const State& b) {
  return std::memcmp(a.force.data(), b.force.data(), sizeof(Vec3)) == 0 &&
         std::memcmp(a.stiffness.data(), b.stiffness.data(), sizeof(Mat3)) == 0 && a.energy == b.energy &&
         a.solve.status == b.solve.status && a.at == b.at;
}

}  // namespace

TEST_CASE("fast states are within 1e-6 of tight ones, all laws; stiffness and energy too") {
  for (const Law law : all_laws()) {
    const auto body = block_body(law);
    GenerateReport report;
    const auto states = generate(body, small_box(2), {}, &report);
    CHECK(report.failed == 0);
    CHECK(states.size() == lattice(small_box(2).box, 0.006).size());
    Solver solver(body);
    std::size_t i = 0;
    for (const auto& [k, state] : states) {
      if (++i % 23 != 0 || state.at.norm() == 0) continue;
      const State tight = solver.reference(state.at, 0.006).state;
      REQUIRE(tight.solve.status == SolveStatus::converged);
      INFO(name(law) << " at " << state.at.transpose());
      const double tolerance = law == Law::st_venant_kirchhoff ? 5e-6 : 1e-6;
      CHECK((state.force - tight.force).norm() < tolerance * tight.force.norm());
      CHECK((state.stiffness - tight.stiffness).norm() < 1e-4 * tight.stiffness.norm());
      CHECK(state.energy == Approx(tight.energy).epsilon(1e-6));
    }
  }
}

TEST_CASE("St. Venant-Kirchhoff with inverted elements: states that are not marked equal those of solve") {
  const auto body = block_body(Law::st_venant_kirchhoff, 0.4);
  LatticeOptions options;
  options.box = {Vec3(-0.042, -0.036, -0.012), Vec3(0.006, 0.012, 0.012)};
  options.threads = 2;
  const auto states = generate(body, options);
  Solver solver(body);
  std::size_t inverted = 0, marked = 0, checked = 0;
  for (const auto& [k, state] : states) {
    REQUIRE(state.solve.status == SolveStatus::converged);
    inverted += state.solve.min_jacobian <= 0;
    marked += state.solve.multivalued;
    if (state.solve.multivalued || state.at.norm() == 0 ||
        (state.solve.min_jacobian > 0 && ++checked % 5 != 0))
      continue;
    const State tight = solver.reference(state.at, options.spacing).state;
    REQUIRE(tight.solve.status == SolveStatus::converged);
    INFO("at " << state.at.transpose() << ", least det F " << state.solve.min_jacobian);
    CHECK((state.force - tight.force).norm() < 5e-6 * tight.force.norm());
    CHECK((state.stiffness - tight.stiffness).norm() < 2e-4 * tight.stiffness.norm());
  }
  CHECK(inverted > states.size() / 10);
  CHECK(marked < states.size() / 2);
}

TEST_CASE(
    "large steps, and states outside of the coarse lattice, equal tight solves along the straight path") {
  for (const double poisson : {0.4, 0.49}) {
    const auto body = block_body(Law::neo_hookean, poisson, 2);
    LatticeOptions options;
    options.spacing = 0.012;
    options.box = {Vec3(-0.036, -0.024, -0.036), Vec3(0.036, 0.012, 0.012)};
    options.threads = 2;
    std::vector<State> states;
    const GenerateReport report =
        generate_lattice(body, options, [&](State s) { states.push_back(std::move(s)); });
    CHECK(report.failed == 0);
    REQUIRE(states.size() == lattice(options.box, options.spacing).size());
    Solver solver(body);
    std::size_t checked = 0;
    for (const State& state : states) {
      const Vec3 k = state.at / options.spacing;
      const bool outside = k.cwiseAbs().maxCoeff() > 2.5;
      if (state.solve.multivalued || state.at.norm() == 0 || (!outside && ++checked % 7 != 0)) continue;
      const State tight = solver.reference(state.at, options.spacing).state;
      REQUIRE(tight.solve.status == SolveStatus::converged);
      INFO("at " << k.transpose() << ", nu " << poisson);
      CHECK((state.force - tight.force).norm() < 1e-6 * tight.force.norm());
      CHECK((state.stiffness - tight.stiffness).norm() < 1e-4 * tight.stiffness.norm());
    }
  }
}

TEST_CASE(
    "the states are the same whatever the thread count, bit for bit; the times show what threads can do") {
  const auto body = block_body(Law::neo_hookean);
  GenerateReport report;
  const auto one = generate(body, small_box(1), {}, &report);
  CHECK(report.parallel.path > 0);
  for (const int threads : {2, 3, 7}) {
    const auto more = generate(body, small_box(threads), {}, &report);
    REQUIRE(more.size() == one.size());
    for (const auto& [k, state] : one) CHECK(same_bits(state, more.at(k)));
    CHECK(report.parallel.path < report.parallel.work);
    CHECK(report.parallel.idle <= threads * report.seconds);
  }
}

TEST_CASE("a sink that throws ends all threads, with its exception") {
  const auto body = block_body(Law::neo_hookean);
  for (const int threads : {1, 3, 7}) {
    std::size_t given = 0;
    const auto fill = [&](const State&) {
      if (++given == 9) throw std::runtime_error("full");
    };
    CHECK_THROWS_WITH(generate_lattice(body, small_box(threads), fill), "full");
    CHECK(given == 9);
  }
}

TEST_CASE("a plan's pieces come after those that they wait for, and look at no other nodes") {
  const SweepPlan plan(small_box(1), {});
  const std::vector<SweepPiece> pieces = pieces_of(plan);
  std::vector<std::set<LatticeIndex>> known(pieces.size());  // coarse nodes solved before, by piece
  std::vector<std::size_t> waits(pieces.size(), 0);
  std::size_t states = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    states += pieces[i].states.size();
    CHECK(pieces[i].waits_for == waits[i]);
    for (const LatticeIndex& c : nodes_looked_at(plan.planes(), pieces[i].states)) {
      // the node beyond a parent counts only if it is nearer to rest
      if (pieces[i].is_coarse && level(c) >= level(pieces[i].states.front())) continue;
      CHECK(known[i].contains(c));
    }
    for (const std::size_t other : pieces[i].before) {
      REQUIRE(other > i);
      ++waits[other];
      known[other].insert(known[i].begin(), known[i].end());
      known[other].insert(pieces[i].states.front());
    }
  }
  CHECK(states == plan.positions());
}

TEST_CASE(
    "an interrupted lattice resumes and ends with the same states; failed ones are not tried "
    "again") {
  const auto body = block_body(Law::neo_hookean);
  const auto whole = generate(body, small_box(2));
  std::vector<State> known;
  std::size_t i = 0;
  for (const auto& [k, state] : whole)
    if (i++ % 3 != 0) known.push_back(state);
  known[5].solve.status = SolveStatus::diverged;
  GenerateReport report;
  const auto rest = generate(body, small_box(2), known, &report);
  CHECK(report.resumed == known.size());
  CHECK(rest.size() + known.size() == whole.size());
  for (const auto& [k, state] : rest) CHECK(same_bits(state, whole.at(k)));
}

TEST_CASE("a stopped lattice hands over only finished states, which are kept") {
  const auto body = block_body(Law::neo_hookean);
  std::stop_source stop;
  LatticeOptions options = small_box(2);
  options.stop = stop.get_token();
  std::vector<State> kept;
  const GenerateReport report = generate_lattice(body, options, [&](State s) {
    kept.push_back(std::move(s));
    if (kept.size() == 20) stop.request_stop();
  });
  CHECK(kept.size() >= 20);
  CHECK(kept.size() < lattice(options.box, 0.006).size());
  CHECK(report.solved == kept.size());
  for (const State& s : kept) CHECK(s.solve.status == SolveStatus::converged);
}

TEST_CASE("an exception in the sink comes out of generate_lattice") {
  const auto body = block_body(Law::neo_hookean);
  const auto full = [](State) { throw std::runtime_error("disk full"); };
  CHECK_THROWS_WITH(generate_lattice(body, small_box(2), full), "disk full");
}
