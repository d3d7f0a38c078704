// forefeel-bench approx [SCENE]: one table, speed against error, of every method on a real state space.
//   speed  fit, update and evaluation, compared with Eigen's LU of the whole saddle system and with a scalar sum, in
//          the same run and with the same instruction set (FOREFEEL_ISA selects a lower one). The series are timed
//          one after the other, so that each finds its own data in the caches. Medians, one thread.
//   error  against tight solves at random positions: inside the lattice, beyond a flat front of known states, and with
//          fewer and fewer states

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "approx/methods/older_methods.hpp"
#include "approx/model/force_makers.hpp"
#include "apps/bench/bench.hpp"
#include "apps/bench/bench_approx_parts.hpp"
#include "apps/bench/bench_approx_time.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {

namespace {

using namespace bench;

struct Kind {
  std::string name;
  Kernel kernel;
  Data data;
  std::vector<std::size_t> neighbours;
};

const std::vector<Kind> kinds = {
    {"r", Kernel::linear, Data::force, {100, 300}},
    {"r3", Kernel::cubic, Data::force, {100, 300}},
    {"r5", Kernel::quintic, Data::force, {100, 300}},
    {"hermite-r3", Kernel::cubic, Data::force_and_stiffness, {25, 75}},
    {"hermite-r5", Kernel::quintic, Data::force_and_stiffness, {8, 25, 75}},
    {"jet", Kernel::quintic, Data::jet, {1, 8}},
};

Errors errors_of(const std::vector<double>& values) {
  return {median(values), quantile_of(values, 0.95, QuantileRule::inverted_cdf), quantile_of(values, 1)};
}

StateSpace space_of(const std::vector<State>& states, StateSpaceOptions options) {
  StateSpace space(options);
  for (const State& s : states) space.insert(s);
  return space;
}

// Against the references.
Errors judge(const std::vector<State>& references, ForceMaker&& models) {
  std::vector<double> errors;
  for (const State& s : references)
    errors.push_back((models.at({s.at}).force(Place{s.at}) - s.force).norm() /
                     std::max(s.force.norm(), 0.05));
  return errors_of(errors);
}

class Bench {
 public:
  Bench(const Globals& globals, Case taken, Progress& progress)
      : globals_(globals),
        progress_(progress),
        case_(std::move(taken)),
        space_(space_of(case_.states, case_.options)) {
    std::vector<State> half;
    for (const State& s : case_.states)
      if (s.at[0] <= case_.front + 1e-9) half.push_back(s);
    half_ = std::move(half);
    half_space_.emplace(space_of(half_, case_.options));
    for (const int step : {1, 2, 3, 4, 6}) thin(step);
  }

  void run() {
    notes = case_.notes;
    std::map<std::size_t, std::vector<std::string>> too_few;
    std::size_t done = 0, all = 0;
    for (const Kind& kind : kinds) all += kind.neighbours.size();
    for (const Kind& kind : kinds)
      for (const std::size_t n : kind.neighbours) {
        progress_.show(0.5 + 0.4 * double(done++) / double(all), fmt::format("{} with {}", kind.name, n));
        if (n + replacements[2] <= space_.size())
          measure(kind, n);
        else
          too_few[n].push_back(kind.name);
      }
    for (const auto& [n, names] : too_few)
      notes.push_back(
          fmt::format("{} with n = {}: needs {} states ({} to replace), the lattice has {}, left out",
                      fmt::join(names, ", "), n, n + replacements[2], replacements[2], space_.size()));
    for (const Method method : all_methods())
      if (method != Method::rbf) {
        progress_.show(0.9, std::string(name(method)));
        try {
          measure_older(method);
        } catch (const InputError& error) {  // the states do not suit the method
          notes.push_back(fmt::format("{}: {}, left out", name(method), error.what()));
        }
      }
  }

  std::vector<Comparison> rows;
  std::vector<Measured> table;
  std::vector<std::string> notes;  // what was left out, and why
  const Case& the_case() const { return case_; }
  std::size_t known() const { return space_.size(); }

 private:
  // Every step-th plane of the lattice.
  void thin(int step) {
    const double h = step * case_.options.spacing;
    std::vector<State> kept;
    for (const State& s : case_.states) {
      bool on = true;
      for (int d = 0; d < 3; ++d) on = on && std::abs(s.at[d] / h - std::round(s.at[d] / h)) < 1e-6;
      if (on) kept.push_back(s);
    }
    StateSpaceOptions options = case_.options;
    options.spacing = h;
    sparser_.push_back({std::move(kept), space_of({}, options)});
    for (const State& s : sparser_.back().states) sparser_.back().space.insert(s);
  }

  void measure(const Kind& kind, std::size_t n) {
    ModelOptions options{.kernel = kind.kernel, .data = kind.data, .neighbours = n};
    Measured m;
    m.method = kind.name;
    m.n = n;
    m.inside = judge(case_.inside, PlaceModels(space_, options));
    for (const auto& plane : case_.outside)
      m.outside.push_back(judge(plane.references, PlaceModels(*half_space_, options)));
    count_states(m, [&](const Sparser& s) {
      ModelOptions fewer = options;
      fewer.neighbours = std::min(n, s.space.size());
      return judge(case_.inside, PlaceModels(s.space, fewer)).p95;
    });
    if (kind.data == Data::jet) {
      time_jets(globals_, case_, space_, options, m, rows);
    } else {
      std::vector<StateId> ids;
      space_.nearest(case_.options.box.centre(), 3 * n, ids);
      std::vector<Sample> pool;
      for (const StateId id : ids)
        pool.push_back({id, space_[id].at, space_[id].force, space_[id].stiffness});
      time_model(globals_, case_, pool, options, m, rows);
    }
    table.push_back(std::move(m));
  }

  struct Sparser {
    std::vector<State> states;
    StateSpace space;
  };

  template <class Judge>
  void count_states(Measured& m, const Judge& p95_with) {
    for (const Sparser& s : sparser_) {  // fewer and fewer states
      const double p95 = p95_with(s);
      if (p95 <= 0.01) m.states_for_1 = s.states.size();
      if (p95 <= 0.07) m.states_for_7 = s.states.size();
    }
  }

  void measure_older(Method method) {
    const auto field_of = [&](const std::vector<State>& states, double spacing) {
      MethodOptions options{.model = {.kernel = Kernel::cubic, .length = spacing}, .spacing = spacing};
      return std::make_unique<const Approximation>(method, states, options);
    };
    const auto judged = [&](const std::vector<State>& references, const std::vector<State>& states,
                            double spacing) {
      try {
        return judge(references, OneModel([&] { return field_of(states, spacing); }));
      } catch (const InputError&) {  // these states do not suit the method
        return Errors{};
      }
    };
    const double h = case_.options.spacing;
    Measured m;
    m.method = name(method);
    m.n = space_.size();
    const double start = now_us();
    const std::unique_ptr<const Approximation> field = field_of(case_.states, h);
    m.refit = now_us() - start;
    m.inside = judged(case_.inside, case_.states, h);
    for (const auto& plane : case_.outside) m.outside.push_back(judged(plane.references, half_, h));
    count_states(
        m, [&](const Sparser& s) { return judged(case_.inside, s.states, s.space.options().spacing).p95; });
    std::vector<Vec3> at;
    for (const State& s : case_.inside) at.push_back(s.at);
    std::vector<double> times;
    for (int block = 0; block < 32; ++block)
      times.push_back(evaluation_us(
          globals_, [&](const Vec3& x) { return field->force(x); }, at, 400));
    m.evaluate = median(times);
    table.push_back(std::move(m));
  }

  const Globals& globals_;
  Progress& progress_;
  Case case_;
  StateSpace space_;
  std::vector<State> half_;
  std::optional<StateSpace> half_space_;
  std::vector<Sparser> sparser_;
};

void write_folder(const Globals& globals, const std::string& folder, const Case& taken,
                  const std::vector<Measured>& table) {
  const std::filesystem::path at(folder);
  write_whole(at / "approx.csv", table_csv(taken, table));
  if (const auto picture = draw_svg("approx", 1200, 560, pareto_plot(table)))
    write_whole(at / "approx.svg", *picture);
  else
    warn(globals, "gnuplot is missing or failed: no picture");
}

}  // namespace

int bench_approx(const Globals& globals, const std::string& scene, const std::string& folder) {
  scene.empty()
      ? built_in_scene(globals.set)
      : load_scene(scene, globals.set, nullptr, {.spacing = false});  // a bad one leaves no folder behind
  claim_bench_folder(folder, {"approx.csv", "approx.svg"});
  Json document;
  {
    Progress progress(globals, "bench approx");
    Bench bench(globals, take_case(globals, scene, progress), progress);
    bench.run();
    print_tables(globals, bench.the_case(), bench.known(), bench.rows, bench.table);
    if (!folder.empty()) write_folder(globals, folder, bench.the_case(), bench.table);
    document = document_of(bench.the_case(), bench.rows, bench.table, bench.notes);
    for (const std::string& note : bench.notes) warn(globals, note);
    if (bench.rows.empty()) warn(globals, "no row could be measured: too few states");
  }
  if (globals.json) print_json(document);
  return document["rows"].empty() ? 1 : 0;
}

}  // namespace forefeel
