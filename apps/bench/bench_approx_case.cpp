// States and references of `forefeel-bench approx`.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "apps/bench/bench_approx_parts.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/error.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel::bench {
namespace {

constexpr std::size_t inside_count = 300, outside_count = 36;
constexpr double tolerance = 1e-9;

void take_body(Case& bench, const Globals& globals, const std::string& file) {
  const Scene scene = file.empty() ? built_in_scene(globals.set) : load_scene(file, globals.set);
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  bench.body = scene.body;
  bench.options = scene.space;
  bench.name = scene.source.file.string();
}

// From the least to the largest lattice position along each axis.
Box reach_of(const std::vector<Vec3>& positions) {
  Box reach{positions.front(), positions.front()};
  for (const Vec3& x : positions) reach = {reach.low.cwiseMin(x), reach.high.cwiseMax(x)};
  return reach;
}

// Positions of the references: inside the lattice, and on planes beyond the front that lie in the lattice.
void take_positions(Case& bench, std::uint64_t seed) {
  const Box& box = bench.reach;
  const double h = bench.options.spacing;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto any = [&] {
    Vec3 x;
    for (int d = 0; d < 3; ++d) x[d] = box.low[d] + unit(random) * box.size()[d];
    return x;
  };
  bench.inside.resize(inside_count);
  for (State& s : bench.inside) s.at = any();
  bench.front = h * std::ceil((box.low[0] + box.size()[0] / 3) / h - 1e-9);
  for (const double distance : {0.006, 0.012, 0.018, 0.024}) {
    Case::Outside plane{distance, {}};
    if (bench.front + distance <= box.high[0] + 1e-9)
      plane.references.resize(outside_count);
    else
      bench.notes.push_back(
          fmt::format("outside at {:.0f} mm: the lattice ends {:.3g} mm beyond the front, left out",
                      1e3 * distance, 1e3 * (box.high[0] - bench.front)));
    for (State& s : plane.references) {
      s.at = any();
      s.at[0] = bench.front + distance;
    }
    bench.outside.push_back(std::move(plane));
  }
}

}  // namespace

Case take_case(const Globals& globals, const std::string& file, Progress& progress) {
  Case bench;
  take_body(bench, globals, file);
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  LatticeOptions options;
  options.spacing = bench.options.spacing;
  options.box = bench.options.box;
  options.threads = threads;
  options.tolerance = tolerance;
  options.jet = 4;
  const std::vector<Vec3> positions = lattice(bench.options.box, bench.options.spacing);
  const std::size_t expected = positions.size();
  bench.reach = reach_of(positions);  // contains at least rest
  generate_lattice(bench.body, options, [&](State s) {
    if (s.usable()) bench.states.push_back(std::move(s));
    progress.show(0.2 * double(bench.states.size()) / double(expected), "states of the lattice");
  });
  if (const std::size_t missing = expected - bench.states.size(); missing > 0)
    bench.notes.push_back(
        fmt::format("{} of {} lattice positions have no state; errors inside are also taken beside them",
                    missing, expected));
  if ((bench.options.box.low - bench.reach.low).norm() + (bench.options.box.high - bench.reach.high).norm() >
      1e-6 * bench.options.spacing)
    bench.notes.push_back(fmt::format(
        "the box is no multiple of the spacing: inside is within the lattice, {:.4g} x {:.4g} x {:.4g} mm",
        1e3 * bench.reach.size()[0], 1e3 * bench.reach.size()[1], 1e3 * bench.reach.size()[2]));
  take_positions(bench, globals.seed);
  std::vector<State*> wanted;
  for (State& s : bench.inside) wanted.push_back(&s);
  for (auto& plane : bench.outside)
    for (State& s : plane.references) wanted.push_back(&s);
  std::size_t done = 0;
#pragma omp parallel num_threads(threads)
  {
    Solver solver(bench.body);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      *wanted[i] = solver.reference(wanted[i]->at, bench.options.spacing).state;
#pragma omp critical
      progress.show(0.2 + 0.3 * double(++done) / double(wanted.size()), "reference solves");
    }
  }
  const auto failed = [](const State& s) { return s.solve.status != SolveStatus::converged; };
  std::size_t unsolved = std::erase_if(bench.inside, failed);
  for (auto& plane : bench.outside) unsolved += std::erase_if(plane.references, failed);
  if (unsolved > 0)
    bench.notes.push_back(
        fmt::format("{} of {} positions to judge by have no reference", unsolved, wanted.size()));
  if (bench.inside.empty())
    throw InputError(bench.name, "no position inside the lattice could be solved, expected some");
  return bench;
}

}  // namespace forefeel::bench
