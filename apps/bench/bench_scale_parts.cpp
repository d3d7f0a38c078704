#include "apps/bench/bench_scale_parts.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <tuple>
#include <utility>

#include "approx/methods/evaluate.hpp"
#include "apps/bench/newton_baseline.hpp"
#include "apps/console/console.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_file.hpp"
#include "solver/system/discretisation.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

constexpr int most_rounds = 3;
constexpr double enough = 5;             // [s]; no further round starts after this
constexpr double cholmod_seconds = 0.5;  // of factorisations, at least

constexpr const char* script = R"(import sys, time
import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
folder, job, threads = sys.argv[1], sys.argv[2], int(sys.argv[3])
at, q, force = (np.fromfile(f"{folder}/{name}").reshape(-1, 3) for name in ("at", "q", "force"))
start = time.perf_counter()
if job == "nearest":
    found = cKDTree(at).query(q, workers=threads)[0]
else:
    found = RBFInterpolator(at, force, neighbors=50, kernel="cubic")(q)
seconds = time.perf_counter() - start
np.ascontiguousarray(found, dtype=float).tofile(f"{folder}/found")
print(seconds)
)";

// OpenMP's number of threads while this lives.
class Threads {
 public:
  explicit Threads(int threads) : before_(omp_get_max_threads()) { omp_set_num_threads(threads); }
  ~Threads() { omp_set_num_threads(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_;
};

// The shortest time of a few rounds of work(), and what that round returned.
template <class Work>
auto shortest(Work&& work) {
  const auto begun = SteadyClock::now();
  std::pair<double, decltype(work())> best{unknown, {}};
  for (int round = 0; round < most_rounds && (round == 0 || seconds_since(begun) < enough); ++round) {
    const auto start = SteadyClock::now();
    auto found = work();
    if (const double took = seconds_since(start); !(best.first <= took)) best = {took, std::move(found)};
  }
  return best;
}

std::vector<Vec3> drawn(std::size_t n, double side, std::mt19937_64& random) {
  std::uniform_real_distribution<double> along(0, side);
  std::vector<Vec3> at(n);
  for (Vec3& x : at)
    for (int axis = 0; axis < 3; ++axis) x[axis] = along(random);
  return at;
}

double per_item(double seconds, std::size_t items) {
  return 1e6 * seconds / static_cast<double>(std::max<std::size_t>(1, items));
}

// Seconds of one tangent assembled and factorised at rest, of `threads` that do so at the same time.
double cholmod_factor(const std::shared_ptr<const Discretisation>& d, int threads) {
  std::vector<std::unique_ptr<BaselineNewton>> solvers;
  for (int i = 0; i < threads; ++i) solvers.push_back(std::make_unique<BaselineNewton>(d, Baseline::cholmod));
  const std::vector<double> rest(static_cast<std::size_t>(d->local_size()), 0.0);
  std::size_t made = 0;
  const auto start = SteadyClock::now();
#pragma omp parallel num_threads(threads) reduction(+ : made)
  do made += solvers[static_cast<std::size_t>(omp_get_thread_num())]->factorise(rest);
  while (seconds_since(start) < cholmod_seconds);
  return seconds_since(start) / static_cast<double>(made);
}

using Position = std::tuple<double, double, double>;
std::map<Position, Vec3> forces_by_position(const std::vector<State>& states) {
  std::map<Position, Vec3> forces;
  for (const State& s : states)
    if (s.usable()) forces[{s.at.x(), s.at.y(), s.at.z()}] = s.force;
  return forces;
}

void fit(std::vector<ScaleRow>& rows) {
  const double serial = fitted_serial_share(rows);
  for (ScaleRow& row : rows) row.serial = serial;
}

}  // namespace

double fitted_serial_share(const std::vector<ScaleRow>& rows) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const ScaleRow& row : rows) {
    const double inverse = 1.0 / row.threads, t = row.seconds();
    n += 1, x += inverse, y += t, xx += inverse * inverse, xy += inverse * t;
  }
  const double determinant = n * xx - x * x;
  if (!(determinant > 1e-12 * n * xx)) return unknown;
  const double slope = (n * xy - x * y) / determinant, base = (y - slope * x) / n;
  return std::clamp(base / (base + slope), 0.0, 1.0);
}

SciPy::SciPy() {
  if (folder_.path().empty()) return;
  std::ofstream(folder_.path() / "job.py") << script;
  for (const char* python : {"python3", "/usr/bin/python3"})
    if (python_.empty() &&
        std::system(fmt::format("{} -c 'import scipy.interpolate' >/dev/null 2>&1", python).c_str()) == 0)
      python_ = python;
}

void SciPy::write(const char* name, const std::vector<Vec3>& rows) const {
  std::ofstream file(folder_.path() / name, std::ios::binary);
  for (const Vec3& row : rows) file.write(reinterpret_cast<const char*>(row.data()), 3 * sizeof(double));
}

SciPy::Found SciPy::run(const std::string& job, int threads) const {
  const std::string folder = folder_.path().string();
  const std::string line = fmt::format(
      "OPENBLAS_NUM_THREADS={0} OMP_NUM_THREADS={0} {1} '{2}/job.py' '{2}' {3} {0} >'{2}/seconds' "
      "2>/dev/null",
      threads, python_, folder, job);
  Found found;
  if (std::system(line.c_str()) != 0) return found;
  std::ifstream(folder + "/seconds") >> found.seconds;
  std::ifstream file(folder + "/found", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  found.values.resize(bytes.size() / sizeof(double));
  std::copy_n(bytes.data(), found.values.size() * sizeof(double),
              reinterpret_cast<char*>(found.values.data()));
  return found;
}

SciPy::Found SciPy::nearest(const std::vector<Vec3>& at, const std::vector<Vec3>& q, int threads) const {
  if (!there()) return {};
  write("at", at), write("q", q), write("force", {});
  return run("nearest", threads);
}

SciPy::Found SciPy::forces(const std::vector<Vec3>& at, const std::vector<Vec3>& force,
                           const std::vector<Vec3>& q) const {
  if (!there()) return {};
  write("at", at), write("q", q), write("force", force);
  return run("forces", 1);
}

std::vector<ScaleRow> scale_generate(const std::string& name, const std::string& scene,
                                     const std::shared_ptr<const Body>& body, const LatticeOptions& lattice,
                                     const std::vector<int>& threads) {
  struct Run {
    GenerateReport report;
    std::vector<State> states;
  };
  const auto d = std::make_shared<const Discretisation>(discretise(*body));
  std::map<Position, Vec3> first;
  std::vector<ScaleRow> rows;
  for (const int p : threads) {
    LatticeOptions options = lattice;
    options.threads = p;
    const auto [seconds, run] = shortest([&] {
      Run made;
      made.report = generate_lattice(body, options, [&](State s) { made.states.push_back(std::move(s)); });
      return made;
    });
    const std::map<Position, Vec3> forces = forces_by_position(run.states);
    if (rows.empty()) first = forces;
    std::vector<double> differences;
    for (const auto& [at, force] : first) {
      const auto same = forces.find(at);
      const double apart =
          same == forces.end() ? 1 : (same->second - force).norm() / std::max(0.05, force.norm());
      differences.push_back(apart);
    }
    const std::size_t n = run.report.solved;
    rows.push_back({.row = {.name = "generate " + name,
                            .baseline = "CHOLMOD, one factorisation",
                            .ours_us = per_item(seconds, n),
                            .baseline_us = 1e6 * cholmod_factor(d, p),
                            .error = p50_p95_max(differences),
                            .n = n},
                    .scene = scene,
                    .body = body,
                    .threads = p,
                    .parallel = run.report.parallel});
  }
  fit(rows);
  return rows;
}

std::vector<ScaleRow> scale_classify(std::size_t states, std::uint64_t seed, const std::vector<int>& threads,
                                     const SciPy& scipy) {
  constexpr double side = 0.1;  // [m]
  std::mt19937_64 random(seed + states);
  const std::vector<Vec3> at = drawn(states, side, random);
  std::vector<Vec3> q = drawn(states, side, random);
  const ScratchFolder folder;
  const fs::path file = folder.path() / "points.csv";
  {
    std::ofstream out(file);
    out << "x,y,z\n";
    for (const Vec3& x : at) out << fmt::format("{},{},{}\n", x.x(), x.y(), x.z());
  }
  std::vector<ScaleRow> rows;
  for (const int p : threads) {
    const Threads set(p);
    // What the command does with a file of points: the same calls.
    const auto [seconds, hole] = shortest([&] {
      const LoadedStates loaded = load_states(file, Tells::places);
      std::vector<Vec3> places;
      for (const State& s : loaded.states) places.push_back(s.at);
      const Regions regions(std::move(places),
                            {.spacing = estimate_spacing(loaded.states), .box = loaded.header.box});
      regions.summary(false);
      regions.fill_distance();
      return regions.largest_hole();
    });
    q.push_back(hole ? hole->centre : Vec3(Vec3::Zero()));
    const SciPy::Found found = scipy.nearest(at, q, p);
    q.pop_back();
    const double apart =
        hole && !found.values.empty() ? std::abs(found.values.back() - hole->radius) / hole->radius : unknown;
    rows.push_back({.row = {.name = "classify",
                            .baseline = "SciPy cKDTree, nearest of as many",
                            .ours_us = per_item(seconds, states),
                            .baseline_us = per_item(found.seconds, states),
                            .error = {apart, apart, apart},
                            .n = states},
                    .scene = "random in a cube",
                    .threads = p});
  }
  fit(rows);
  return rows;
}

std::vector<ScaleRow> scale_evaluate(std::size_t states, std::size_t points, std::uint64_t seed,
                                     const std::vector<int>& threads, const SciPy& scipy) {
  constexpr double side = 0.08;  // [m]
  std::mt19937_64 random(seed + states + points);
  const std::vector<Vec3> at = drawn(states, side, random), q = drawn(points, side, random);
  std::vector<Vec3> force;
  double largest = 0;
  for (const Vec3& x : at) {
    force.push_back(-(200 + 2e4 * x.squaredNorm()) * x + Vec3(std::sin(60 * x.y()), 0, std::cos(40 * x.x())));
    largest = std::max(largest, force.back().norm());
  }
  const std::vector<State> known = measured_states(at, force);
  const SciPy::Found found = scipy.forces(at, force, q);
  std::vector<ScaleRow> rows;
  for (const int p : threads) {
    const Threads set(p);
    EvaluateOptions options;
    options.model = {
        .kernel = Kernel::cubic, .data = Data::force, .neighbours = 50, .select = Select::nearest};
    const auto [seconds, forces] = shortest([&] { return evaluate(known, q, options).made.forces; });
    std::vector<double> differences;
    for (std::size_t i = 0; 3 * i + 2 < found.values.size() && i < forces.size(); ++i)
      differences.push_back((Eigen::Map<const Vec3>(&found.values[3 * i]) - forces[i]).norm() / largest);
    rows.push_back({.row = {.name = fmt::format("evaluate of {} states", states),
                            .baseline = "SciPy RBFInterpolator, one thread",
                            .ours_us = per_item(seconds, points),
                            .baseline_us = per_item(found.seconds, points),
                            .error = p50_p95_max(differences),
                            .n = points},
                    .scene = "random in a cube",
                    .threads = p});
  }
  fit(rows);
  return rows;
}

}  // namespace forefeel
