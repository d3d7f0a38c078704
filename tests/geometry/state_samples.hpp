#pragma once
// States with distinct values in every member, and their comparison to the last bit, for the tests of state
// files.

#include <cmath>
#include <random>
#include <vector>

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel::test {

inline StateFileHeader header() {
  StateFileHeader h;
  h.identity = {{"mesh", "sha256 aa"}, {"material", "sha256 bb"}, {"clamp", "sha256 cc"}};
  h.spacing = 0.006;
  h.box = {{-0.036, -0.03, -0.024}, {0.036, 0.03, 0.036}};
  h.notes["scene"] = "[body]\nphantom = \"liver\"\n";
  return h;
}

inline State state(int i, bool full = true) {
  std::mt19937 random(static_cast<unsigned>(i));
  std::uniform_real_distribution<double> uniform(-1, 1);
  State s;
  s.at = {uniform(random), uniform(random), i * 1e-3};
  s.force = {uniform(random), uniform(random), uniform(random)};
  if (!full) return s;
  for (int k = 0; k < 9; ++k) s.stiffness(k / 3, k % 3) = 100 * uniform(random);
  s.energy = uniform(random), s.spacing = 0.012, s.solve.status = SolveStatus::converged,
  s.solve.multivalued = i % 2 == 1;
  s.solve.iterations = i, s.solve.residual = 1e-11, s.solve.seconds = 0.004, s.solve.min_jacobian = 0.7;
  s.solve.parent = {0.1, 0.2, uniform(random)};
  if (i % 3 == 0)
    s.displacements =
        std::make_shared<const std::vector<double>>(std::vector<double>{1, 2, 3, uniform(random), 5, 6});
  return s;
}

inline std::shared_ptr<const EnergyJet> jet(int order, int i) {
  std::mt19937 random(static_cast<unsigned>(1000 + i));
  std::uniform_real_distribution<double> uniform(-1e5, 1e5);
  EnergyJet jet{.order = order};
  if (i % 2 == 0) jet.limit = 0.01 + 1e-6 * uniform(random) / 1e5;
  for (std::size_t k = 0; k < jet_terms_of_order(order); ++k) jet.coefficients[k] = uniform(random);
  return std::make_shared<const EnergyJet>(jet);
}

inline bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}
inline bool same(const Vec3& a, const Vec3& b) {
  return same(a[0], b[0]) && same(a[1], b[1]) && same(a[2], b[2]);
}

inline bool same(const EnergyJet* a, const EnergyJet* b) {
  if (!a || !b) return !a && !b;
  return a->order == b->order && a->limit == b->limit && a->coefficients == b->coefficients;
}

inline bool same(const State& a, const State& b) {
  for (int k = 0; k < 9; ++k)
    if (!same(a.stiffness(k / 3, k % 3), b.stiffness(k / 3, k % 3))) return false;
  const bool displaced =
      a.displacements ? b.displacements && *a.displacements == *b.displacements : !b.displacements;
  return same(a.at, b.at) && same(a.force, b.force) && same(a.energy, b.energy) &&
         same(a.spacing, b.spacing) && a.solve.status == b.solve.status &&
         a.solve.multivalued == b.solve.multivalued && a.solve.iterations == b.solve.iterations &&
         same(a.solve.residual, b.solve.residual) && same(a.solve.seconds, b.solve.seconds) &&
         same(a.solve.min_jacobian, b.solve.min_jacobian) && same(a.solve.parent, b.solve.parent) &&
         displaced && same(a.jet.get(), b.jet.get());
}

inline std::vector<State> states(int n) {
  std::vector<State> all;
  for (int i = 0; i < n; ++i) all.push_back(state(i, i % 4 != 3));
  return all;
}

// With jets of order 2, 3 and 4, and without.
inline std::vector<State> states_with_jets(int n) {
  std::vector<State> all = states(n);
  for (int i = 0; i < n; ++i)
    if (const int order = 1 + i % 4; order > 1) all[static_cast<std::size_t>(i)].jet = jet(order, i);
  return all;
}

}  // namespace forefeel::test
