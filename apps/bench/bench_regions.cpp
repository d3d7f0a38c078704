#include "apps/bench/bench_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/setups.hpp"

namespace forefeel {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double h = 0.006;

struct Situation {
  std::string name;
  std::vector<Vec3> known, fresh;
  Box box;
};

Box around(const Vec3& centre) {
  return {centre - Vec3::Constant(12 * h), centre + Vec3::Constant(12 * h)};
}

std::vector<Vec3> jittered_lattice(long side, std::mt19937_64& random) {
  std::uniform_real_distribution<double> jitter(-0.2 * h, 0.2 * h);
  std::vector<Vec3> all;
  const double half = 0.5 * static_cast<double>(side - 1);
  for (long k = 0; k < side; ++k)
    for (long j = 0; j < side; ++j)
      for (long i = 0; i < side; ++i)
        all.push_back(h * (Vec3(double(i), double(j), double(k)) - Vec3::Constant(half)) +
                      Vec3(jitter(random), jitter(random), jitter(random)));
  return all;
}

std::vector<Situation> situations(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const long side = std::lround(std::cbrt(static_cast<double>(n)));
  const double half = 0.5 * static_cast<double>(side - 1) * h;
  const auto anywhere = [&](double reach) {
    return Vec3(reach * uniform(random), reach * uniform(random), reach * uniform(random));
  };
  std::vector<Situation> all(3);
  all[0] = {"path", jittered_lattice(side, random), {}, around(Vec3::Zero())};
  const double r = std::min(0.8 * half, 11 * h);
  for (int i = 0; i < 200; ++i) {
    const double s = 0.25 * h / r * i;
    all[0].fresh.push_back(Vec3(r * std::sin(s), r * std::sin(1.3 * s + 0.4), r * std::sin(0.7 * s + 1.1)) +
                           anywhere(0.05 * h));
  }
  all[1] = {"scattered", {}, {}, around(Vec3::Zero())};
  for (std::size_t i = 0; i < n; ++i) all[1].known.push_back(anywhere(1.26 * half));  // one in two cubes of h
  for (int i = 0; i < 100; ++i) all[1].fresh.push_back(anywhere(std::min(half, 11 * h)));
  all[2] = {"front", all[0].known, {}, around(Vec3(half, 0, 0))};
  for (int i = 1; i <= 5; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k)
        all[2].fresh.push_back(Vec3(half, 0, 0) + h * Vec3(i, j, k) + anywhere(0.1 * h));
  return all;
}

RegionCost measure(const Situation& situation) {
  StateSpace space({.spacing = h, .box = situation.box});
  const auto add = [&](const Vec3& at) {
    State state;
    state.at = at;
    space.insert(std::move(state));
  };
  for (const Vec3& at : situation.known) add(at);
  std::vector<double> look, whole;
  const auto since = [](Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  };
  double sum = 0;
  const Vec3 ahead = Vec3(0.8, 0.36, -0.48);
  for (const Vec3& at : situation.fresh) {
    add(at);
    const auto start = Clock::now();
    for (int i = 0; i <= 8; ++i) sum += static_cast<double>(space.region_label(at + 0.25 * h * i * ahead));
    look.push_back(since(start));
  }
  for (int i = 0; i < 3; ++i) {
    const auto start = Clock::now();
    sum += static_cast<double>(space.regions().label_at(situation.box.centre()));
    whole.push_back(since(start));
  }
  return {situation.name, median(look), median(whole), situation.known.size(), sum};
}

struct SetupAgreement {
  std::string setup;
  double width = 0, share = 0;
  std::size_t states = 0;
};

using Agreements = std::vector<SetupAgreement>;

const JsonKeys<Agreements>& agreement_keys() {
  static const JsonKeys<Agreements> keys{json_list<Agreements, SetupAgreement>(
      "agreement",
      {{"setup", "", "bench coverage: arrangement of the states", &SetupAgreement::setup},
       {"width", "m", "of its empty part", &SetupAgreement::width},
       {"share", "1", "share of the volume where Delaunay and octree labels agree", &SetupAgreement::share},
       {"states", "", "in it", &SetupAgreement::states}},
      [](const Agreements& all) { return all; })};
  return keys;
}

}  // namespace

DeclaredTable declared_bench_coverage() {
  return bench_table("coverage", {declared(agreement_keys())});
}

std::vector<RegionCost> bench_regions(std::size_t n, std::uint64_t seed) {
  std::vector<RegionCost> costs;
  for (const Situation& situation : situations(n, seed)) costs.push_back(measure(situation));
  return costs;
}

void report_agreement(const Globals& globals, nlohmann::ordered_json& out) {
  Agreements agreements;
  say(globals, "");
  say(globals,
      fmt::format("{:<10}{:>10}{:>12}   labels agree on this share of the volume, common blank left out",
                  "setup", "width [mm]", "share"));
  for (const double width : {0.048, 0.120})
    for (const std::string& name : setup_names()) {
      const Setup setup = make_setup(name, {.width = width});
      StateSpace space({.spacing = h, .box = setup.box});
      OctreeIndex octree(h);
      for (const Vec3& at : setup.states) {
        State state;
        state.at = at;
        octree.insert(space.insert(std::move(state)).id, at);
      }
      const Agreement agreement = compare_indexes(space.regions(), octree);
      agreements.push_back({name, width, agreement.share, setup.states.size()});
      say(globals, fmt::format("{:<10}{:>10.3g}{:>12.4f}", name, 1e3 * width, agreement.share));
    }
  add_to(out, agreement_keys(), agreements);
}

}  // namespace forefeel
