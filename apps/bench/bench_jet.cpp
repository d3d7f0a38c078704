// forefeel-bench jet [SCENE]: the energy jet at rest alone against tight solves, and what it costs beside the state.
// Positions are drawn in the scene's box; errors are relative to the force there, or to session.error_floor.
//   radius   the distance from rest to which every error stays below 7 %
//   us       time of the jet, factor and tangent at hand, best of many; baseline: one factorisation at rest, in turns

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/laboratory.hpp"
#include "geometry/common/counted.hpp"
#include "scheduling/motion/random.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/jet/jet_maker.hpp"

namespace forefeel {
namespace {

constexpr std::size_t positions = 100;
constexpr int rounds = 60;
constexpr double felt = 0.07;  // the just noticeable difference

struct JetRow {
  int order = 1;
  double us = 0;
  BenchTime factor = {};  // the fastest
  std::vector<double> errors;
  double radius = 0;  // [m]
};

const JsonKeys<JetRow>& jet_keys() {
  static const JsonKeys<JetRow> keys{
      {"order", "", "bench jet: of the force; 1: the stiffness alone", &JetRow::order},
      {"radius", "m", "distance from rest to which every error stays below 7 %", &JetRow::radius},
      {"us", "us", "time of the jet, factor and tangent at hand", &JetRow::us}};
  return keys;
}

std::vector<Vec3> drawn(const Box& box, std::uint64_t seed) {
  std::vector<Vec3> list;
  for (std::size_t i = 0; i < positions; ++i) {
    Vec3 share;
    for (int axis = 0; axis < 3; ++axis)
      share[axis] =
          static_cast<double>(random::mix(seed + 11, 3 * i + static_cast<std::size_t>(axis)) >> 11) * 0x1p-53;
    list.push_back(box.low + share.cwiseProduct(box.size()));
  }
  return list;
}

// Of the tangent, the jets and the factor at rest.
void measure_times(const Body& body, std::vector<JetRow>& rows) {
  const auto d = analyse(body);
  const auto size = static_cast<std::size_t>(d->local_size());
  const std::vector<double> rest(size, 0.0);
  std::vector<double> blocks(9 * static_cast<std::size_t>(d->pattern.size() + 1), 0.0), tangent(3 * size);
  d->elements.hessian(rest.data(), blocks.data());
  Factorisation factor(*d);
  JetMaker maker(d);
  for (JetRow& row : rows) row.us = row.factor.wall_us = std::numeric_limits<double>::infinity();
  rows[0].us = 0;
  for (int round = 0; round < rounds; ++round) {
    const BenchTime start = bench_time();
    if (!factor.compute(blocks.data())) return;
    const BenchTime took = bench_time() - start;
    factor.tangent(tangent.data());
    for (JetRow& row : rows) {
      if (took.wall_us < row.factor.wall_us) row.factor = took;
      if (row.order < 2) continue;
      const double begun = now_us();
      maker.at(rest, tangent, factor, row.order);
      row.us = std::min(row.us, now_us() - begun);
    }
  }
}

// Errors of each order at the positions whose solve converged, by distance.
void measure_errors(const Scene& scene, std::vector<Vec3> at, Progress& progress, std::vector<JetRow>& rows) {
  std::ranges::sort(at, {}, [](const Vec3& x) { return x.norm(); });
  Solver solver(scene.body);
  SolveOptions options;
  options.jet = most_jet_order;
  const State rest = solver.reference(Vec3::Zero(), 1, options).state;
  for (std::size_t i = 0; i < at.size(); ++i) {
    progress.show(static_cast<double>(i) / static_cast<double>(at.size()), "tight solves");
    const State truth = solver.reference(at[i], scene.space.spacing).state;
    if (!truth.usable() || !rest.jet) continue;
    const double scale = std::max(truth.force.norm(), scene.session.judging.error_floor);
    for (JetRow& row : rows) {
      const Vec3 force =
          rest.force - rest.stiffness * at[i] - jet_terms(*rest.jet, at[i], row.order + 1).gradient;
      row.errors.push_back((force - truth.force).norm() / scale);
      const bool held = std::ranges::all_of(row.errors, [](double e) { return e < felt; });
      if (held) row.radius = at[i].norm();
    }
  }
}

}  // namespace

DeclaredTable declared_bench_jet() {
  return bench_table("jet", {below("rows[]", declared(jet_keys())), declared(instruction_set_keys())});
}

int bench_jet(const Globals& globals, const std::string& name) {
  const Laboratory laboratory(globals, name);
  const Scene& scene = laboratory.scene();
  Progress progress(globals, "bench jet");
  std::vector<JetRow> rows;
  for (int order = 1; order <= most_jet_order; ++order) rows.push_back({.order = order, .errors = {}});
  measure_times(*scene.body, rows);
  measure_errors(scene, drawn(scene.space.box, globals.seed), progress, rows);
  Json document{{"rows", Json::array()}};
  std::vector<std::string> lines;
  for (const JetRow& row : rows) {
    const std::vector<double> error = p50_p95_max(row.errors);
    Json json = row_json({.name = fmt::format("jet of order {}", row.order),
                          .baseline = "factorisation at rest",
                          .ours_us = row.us,
                          .baseline_us = row.factor.wall_us,
                          .error = error,
                          .n = row.errors.size(),
                          .baseline_processor_us = row.factor.processor_us},
                         {.scene = laboratory.name(), .body = scene.body.get(), .tolerance = 1e-10});
    add_to(json, jet_keys(), row);
    document["rows"].push_back(json);
    lines.push_back(
        fmt::format("order {}: {:7.1f} us (a factorisation {:.0f} us); error p50 {}, p95 {}, max "
                    "{} of {} "
                    "positions; below 7 % to {:.3g} mm",
                    row.order, row.us, row.factor.wall_us, in_percent(error[0]), in_percent(error[1]),
                    in_percent(error[2]), row.errors.size(), 1e3 * row.radius));
  }
  const BenchEnd end{scene.source.hash};
  for (const JsonKeys<BenchEnd>& keys : {instruction_set_keys(), provenance_keys()})
    add_to(document, keys, end);
  if (globals.json) print_json(document);
  for (const std::string& line : lines) say(globals, line);
  return 0;
}

}  // namespace forefeel
