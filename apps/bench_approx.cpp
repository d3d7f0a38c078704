// forefeel bench approx [SCENE]: fit, update and evaluation of the approximation on a real state space,
// beside Eigen's LU of the whole saddle system and a scalar sum, of the same instruction set and in the same
// run; errors against tight solves at random positions of the box. One thread.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <random>

#include "approx/baselines/baseline.hpp"
#include "approx/instruction_set.hpp"
#include "apps/command.hpp"
#include "apps/provenance.hpp"
#include "apps/scene.hpp"
#include "geometry/phantom.hpp"
#include "solver/solver.hpp"

namespace forefeel {
namespace {

constexpr std::size_t reference_count = 100;
constexpr int rounds = 60;

double now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return unknown;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * double(values.size())))];
}

struct Case {
  std::shared_ptr<const Body> body;
  StateSpaceOptions options;
  std::string name;
  std::vector<State> states, references;
};

Case take_case(const Globals& globals, const std::string& file) {
  Case bench;
  if (!file.empty()) {
    const Scene scene = load_scene(file, globals.set);
    for (const std::string& warning : scene.warnings) warn(globals, warning);
    bench.body = scene.body;
    bench.options = scene.space;
    bench.name = scene.file.string();
  } else {
    auto body = std::make_shared<Body>();
    body->mesh = phantom("liver");
    body->clamp = body->mesh.groups.at("clamp");
    body->contact = body->mesh.groups.at("contact");
    bench.body = body;
    bench.options.spacing = 0.006;
    bench.options.box = {Vec3(-0.036, -0.036, -0.036), Vec3(0.036, 0.036, 0.024)};
    bench.name = "liver phantom";
  }
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  GenerateOptions options;
  options.spacing = bench.options.spacing;
  options.box = bench.options.box;
  options.threads = threads;
  options.tolerance = 1e-9;
  generate_lattice(bench.body, options, {},
                   [&](State s) {
                     if (s.usable()) bench.states.push_back(std::move(s));
                   },
                   {});
  bench.references.resize(reference_count);
  std::mt19937_64 random(globals.seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (State& s : bench.references)
    for (int d = 0; d < 3; ++d) s.at[d] = options.box.low[d] + unit(random) * options.box.size()[d];
#pragma omp parallel num_threads(threads)
  {
    Solver solver(bench.body);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < bench.references.size(); ++i)
      bench.references[i] = solver.reference(bench.references[i].at, bench.options.spacing).state;
  }
  std::erase_if(bench.references, [](const State& s) { return s.status != SolveStatus::converged; });
  return bench;
}

struct Kind {
  std::string name;
  Kernel kernel;
  Data data;
  std::size_t n;
};

class Bench {
 public:
  Bench(const Globals& globals, Case bench)
      : globals_(globals), case_(std::move(bench)), space_(case_.options) {
    for (const State& s : case_.states) space_.insert(s);
  }

  void run(const Kind& kind) {
    const ModelOptions options{
        .kernel = kind.kernel, .data = kind.data, .neighbours = std::min(kind.n, space_.size())};
    measure_errors(options);
    std::vector<StateId> ids;
    space_.nearest(case_.options.box.centre(), 3 * options.neighbours, ids);
    if (ids.size() < options.neighbours + 20) return;
    pool_.clear();
    for (const StateId id : ids) pool_.push_back({id, space_[id].at, space_[id].force, space_[id].stiffness});
    const bool hermite = kind.data == Data::force_and_stiffness;
    measure_fits(kind, options, hermite);
    if (!hermite) measure_evaluation(kind, options);
  }

  nlohmann::ordered_json rows = nlohmann::ordered_json::array();

 private:
  void row(const std::string& what, const Kind& kind, const char* baseline, const std::vector<double>& ours,
           const std::vector<double>& theirs, std::optional<std::size_t> k) {
    const double a = quantile(ours, 0.5), b = quantile(theirs, 0.5);
    nlohmann::ordered_json r;
    r["name"] = what + " " + kind.name;
    r["baseline"] = baseline;
    r["ratio"] = number(b / a);
    r["ours_us"] = number(a);
    r["baseline_us"] = number(b);
    r["error"] = {{"p50", number(quantile(errors_, 0.5))},
                  {"p95", number(quantile(errors_, 0.95))},
                  {"max", number(quantile(errors_, 1))}};
    r["n"] = kind.n;
    if (k)
      r["k"] = *k;
    else
      r["k"] = nullptr;
    r["scene"] = case_.name;
    r["law"] = name(case_.body->material.law);
    r["elements"] = case_.body->mesh.tets.size();
    r["threads"] = 1;
    r["tolerance"] = 1e-9;
    rows.push_back(r);
    say(globals_,
        fmt::format(
            "{:22} n {:3} k {:>2}  {:9.3f} us  {:>28} {:9.3f} us  ratio {:6.2f}  error p50 {:.1e} p95 {:.1e}",
            r["name"].get<std::string>(), kind.n, k ? std::to_string(*k) : "-", a, baseline, b, b / a,
            quantile(errors_, 0.5), quantile(errors_, 0.95)));
  }

  void measure_errors(const ModelOptions& options) {
    errors_.clear();
    ModelUpdater updater(space_, options);
    Model model;
    for (const State& s : case_.references) {
      updater.forget();
      updater.update(s.at, model);
      errors_.push_back((model.force(s.at) - s.force).norm() / std::max(s.force.norm(), 0.05));
    }
  }

  // Refits and updates of the set and the LU of the same system take turns, so that all see the same machine.
  void measure_fits(const Kind& kind, const ModelOptions& options, bool hermite) {
    const std::size_t n = options.neighbours;
    RbfFit fit(options, n);
    LuRefit lu(n, hermite);
    Model model;
    model.reserve(options);
    std::vector<double> refit, theirs;
    double sink = 0;
    for (int r = 0; r < rounds; ++r) {
      double start = now_us();
      fit.refit({pool_.data(), n});
      fit.write(model.impl(), pool_[0].at);
      refit.push_back(now_us() - start);
      start = now_us();
      sink += lu.refit({pool_.data(), n});
      theirs.push_back(now_us() - start);
    }
    row("refit", kind, "Eigen PartialPivLU refit", refit, theirs, std::nullopt);
    fit.set_mode(RbfFit::Mode::update);
    std::vector<std::size_t> in, out;
    for (std::size_t i = 0; i < pool_.size(); ++i) (i < n ? in : out).push_back(i);
    std::mt19937_64 random(globals_.seed);
    for (const std::size_t k : {1, 5, 20}) {
      if (2 * k > n) continue;
      std::vector<double> update;
      theirs.clear();
      refit.clear();
      RbfFit own(options, n);
      for (int r = 0; r < rounds; ++r) {
        std::shuffle(in.begin(), in.end(), random);
        std::shuffle(out.begin(), out.end(), random);
        std::vector<StateId> removed;
        std::vector<Sample> added, all;
        for (std::size_t i = 0; i < k; ++i) {
          removed.push_back(pool_[in[i]].id);
          added.push_back(pool_[out[i]]);
          std::swap(in[i], out[i]);
        }
        std::ranges::sort(removed);
        for (const std::size_t i : in) all.push_back(pool_[i]);
        double start = now_us();
        fit.replace(removed, added);
        fit.write(model.impl(), pool_[0].at);
        update.push_back(now_us() - start);
        start = now_us();
        sink += lu.refit(all);
        theirs.push_back(now_us() - start);
        start = now_us();
        own.refit(all);
        own.write(model.impl(), pool_[0].at);
        refit.push_back(now_us() - start);
      }
      row("update", kind, "Eigen PartialPivLU refit", update, theirs, k);
      row("update", kind, "own refit", update, refit, k);
    }
    if (!std::isfinite(sink)) warn(globals_, "the LU baseline met a singular system");
  }

  void measure_evaluation(const Kind& kind, const ModelOptions& options) {
    RbfFit fit(options, options.neighbours);
    fit.refit({pool_.data(), options.neighbours});
    Model model;
    fit.write(model.impl(), pool_[0].at);
    const std::size_t n = options.neighbours;
    std::vector<double> positions(3 * n), coefficients(3 * n + 12, 0.5), ours, theirs;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t d = 0; d < 3; ++d) {
        positions[3 * i + d] = model.impl().data[d * model.impl().stride + i];
        coefficients[3 * i + d] = model.impl().data[(3 + d) * model.impl().stride + i];
      }
    constexpr int repeats = 200;
    Vec3 sum = Vec3::Zero();
    for (int r = 0; r < rounds; ++r) {
      double start = now_us();
      for (int i = 0; i < repeats; ++i) sum += model.force(pool_[std::size_t(i) % n].at);
      ours.push_back((now_us() - start) / repeats);
      start = now_us();
      for (int i = 0; i < repeats; ++i) {
        double f[3];
        const Vec3 y = (pool_[std::size_t(i) % n].at - model.impl().centre) * model.impl().inverse_scale;
        scalar_evaluate(n, positions.data(), coefficients.data(), y.data(), f);
        sum[0] += f[0];
      }
      theirs.push_back((now_us() - start) / repeats);
    }
    if (!sum.allFinite()) warn(globals_, "an evaluation was not finite");
    row("evaluate", kind, "scalar -O2", ours, theirs, std::nullopt);
  }

  const Globals& globals_;
  Case case_;
  StateSpace space_;
  std::vector<Sample> pool_;
  std::vector<double> errors_;
};

}  // namespace

int bench_approx(const Globals& globals, const std::string& scene) {
  Bench bench(globals, take_case(globals, scene));
  for (const Kind& kind : std::vector<Kind>{{"r3", Kernel::cubic, Data::force, 100},
                                            {"r3", Kernel::cubic, Data::force, 300},
                                            {"hermite-r5", Kernel::quintic, Data::force_and_stiffness, 25},
                                            {"hermite-r5", Kernel::quintic, Data::force_and_stiffness, 75}})
    bench.run(kind);
  nlohmann::ordered_json document;
  document["rows"] = bench.rows;
  document["instruction_set"] = name(instruction_set());
  document["provenance"] = provenance("");
  if (globals.json) print_json(document);
  return 0;
}

}  // namespace forefeel
