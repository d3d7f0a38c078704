// Energy jets of the states of a lattice: those of a Solver at the same place, whoever solves.

#include "block_body.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/states/energy_jet.hpp"
#include "solver/body/law.hpp"
#include "solver/lattice/generate.hpp"
#include "solver/lattice/generate_pieces.hpp"
#include "tests/support/test.hpp"

namespace {

using States = std::map<std::array<double, 3>, State>;

LatticeOptions options_with(int jet, int threads = 2) {
  LatticeOptions options;
  options.spacing = 0.006;
  options.box = {Vec3(-0.012, -0.008, -0.006), Vec3(0.006, 0.012, 0.012)};
  options.threads = threads;
  options.jet = jet;
  return options;
}

std::function<void(State)> into(States& states) {
  return [&states](State s) { states[{s.at[0], s.at[1], s.at[2]}] = std::move(s); };
}

States generated(const std::shared_ptr<const Body>& body, const LatticeOptions& options) {
  States states;
  generate_lattice(body, options, into(states));
  return states;
}

double largest(const EnergyJet& jet, std::size_t begin, std::size_t end) {
  double most = 0;
  for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(jet.coefficients[i]));
  return most;
}

// The largest difference, each degree in shares of the largest coefficient of that degree.
double difference(const EnergyJet& a, const EnergyJet& b) {
  double most = 0;
  for (int order = 2; order <= b.order; ++order) {
    const std::size_t begin = jet_terms_of_order(order - 1), end = jet_terms_of_order(order);
    for (std::size_t i = begin; i < end; ++i)
      most = std::max(most, std::abs(a.coefficients[i] - b.coefficients[i]) / largest(b, begin, end));
  }
  return most;
}

void check_like_solver(const std::shared_ptr<const Body>& body, int order, std::size_t stride) {
  const States states = generated(body, options_with(order));
  Solver solver(body);
  std::size_t i = 0;
  for (const auto& [at, state] : states) {
    REQUIRE(state.jet);
    CHECK(state.jet->order == order);
    if (i++ % stride != 0) continue;
    const State tight = solver.reference(state.at, 0.006, {.jet = order}).state;
    REQUIRE(tight.jet);
    INFO(name(body->material.law) << " order " << order << " at " << state.at.transpose());
    CHECK(difference(*state.jet, *tight.jet) < 1e-6);
    CHECK(state.jet->limit == Approx(tight.jet->limit).epsilon(1e-6));
  }
}

bool same_jets(const States& a, const States& b) {
  return a.size() == b.size() && std::ranges::all_of(a, [&](const auto& entry) {
           const State& s = entry.second;
           const auto found = b.find(entry.first);
           if (found == b.end() || !s.jet || !found->second.jet) return false;
           const EnergyJet &mine = *s.jet, &other = *found->second.jet;
           return s.force == found->second.force && mine.order == other.order && mine.limit == other.limit &&
                  mine.coefficients == other.coefficients;
         });
}

}  // namespace

TEST_CASE("states of a lattice keep the jets that a solver finds there, all laws") {
  for (const Law law : all_laws())
    if (law != Law::linear)
      for (const int order : {2, 3, 4}) check_like_solver(block_body(law), order, 5);
}

TEST_CASE("every state of a phantom's lattice has the jet of a solver at its place") {
  auto body = std::make_shared<Body>();
  body->mesh = phantom("beam", 240);
  body->material = {Law::neo_hookean, 5000, 0.3};
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  check_like_solver(body, 2, 1);
}

TEST_CASE("quadratic elements and a linear law") {
  check_like_solver(block_body(Law::neo_hookean, 0.4, 1, Element::quadratic), 4, 9);
  for (const auto& [at, state] : generated(block_body(Law::linear), options_with(3))) {
    REQUIRE(state.jet);
    CHECK(state.jet->order == 3);
    CHECK(largest(*state.jet, 0, jet_size) == 0);
    CHECK(std::isinf(state.jet->limit));
  }
}

TEST_CASE("a lattice without jets has none, and forces are the same with them") {
  const auto body = block_body(Law::neo_hookean);
  const States plain = generated(body, options_with(1)), with = generated(body, options_with(4));
  REQUIRE(plain.size() == with.size());
  for (const auto& [at, state] : plain) {
    CHECK(!state.jet);
    CHECK(state.force == with.at(at).force);
    CHECK(state.stiffness == with.at(at).stiffness);
  }
}

TEST_CASE("jets do not depend on the threads, nor on who solves a piece") {
  const auto body = block_body(Law::stable_neo_hookean);
  const States one = generated(body, options_with(3, 1));
  CHECK(same_jets(one, generated(body, options_with(3, 2))));
  States states;
  LatticePieces pieces(options_with(3), {}, make_coarse_nodes(), into(states), {});
  LatticeWorker worker(body, options_with(3), make_coarse_nodes());  // as in another process
  while (!pieces.finished()) {
    auto piece = pieces.next(1);
    REQUIRE(piece);
    auto result = worker.solve(Unpacker(std::move(piece->content)));
    REQUIRE(result);
    pieces.done(piece->id, 1, Unpacker(std::move(*result)));
  }
  CHECK(same_jets(one, states));
}
