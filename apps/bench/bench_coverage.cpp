// forefeel-bench coverage: our indexes against plain CGAL and nanoflann, in one run and with the same
// compiler flags. `ratio` is time of the baseline / our time, as medians of repeated batches.

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nanoflann.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_regions.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/delaunay_index.hpp"

namespace forefeel {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangulation = CGAL::Delaunay_triangulation_3<
    Kernel,
    CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>>>;
using Point = Kernel::Point_3;

constexpr double h = 0.006;

struct Cloud {
  std::vector<Vec3> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;

Point point(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// n states of a jittered lattice (one per cell of h), in boustrophedon order so that a plain hint works well.
// A smooth path leads through the middle; the new states on it lie off the lattice.
struct Field {
  std::vector<Vec3> states;
  double half = 0;  // side of the populated cube / 2 [m]
};

Field make_field(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> jitter(-0.2 * h, 0.2 * h);
  const long side = std::lround(std::cbrt(static_cast<double>(n)));
  Field field;
  field.half = 0.5 * static_cast<double>(side - 1) * h;
  for (long k = 0; k < side; ++k)
    for (long j = 0; j < side; ++j)
      for (long i = 0; i < side; ++i) {
        const long row = k % 2 ? side - 1 - j : j, column = (k + j) % 2 ? side - 1 - i : i;
        const Vec3 cell(static_cast<double>(column), static_cast<double>(row), static_cast<double>(k));
        field.states.push_back(h * cell - Vec3::Constant(field.half) +
                               Vec3(jitter(random), jitter(random), jitter(random)));
      }
  return field;
}

std::vector<Vec3> make_path(const Field& field, std::size_t steps, double phase) {
  std::vector<Vec3> path;
  const double r = 0.8 * field.half, advance = 0.06e-3 / r;  // 60 mm/s at 1 kHz
  for (std::size_t i = 0; i < steps; ++i) {
    const double s = phase + advance * static_cast<double>(i);
    path.emplace_back(r * std::sin(s), r * std::sin(1.3 * s + 0.4), r * std::sin(0.7 * s + 1.1));
  }
  return path;
}

// One query or insertion at a time; labels have no error.
BenchRow coverage_row(std::string name, std::string baseline, double ours_us, const BenchTime& theirs,
                      std::size_t n) {
  return {.name = std::move(name),
          .baseline = std::move(baseline),
          .ours_us = ours_us,
          .baseline_us = theirs.wall_us,
          .error = {0, 0, 0},
          .n = n,
          .k = 1,
          .baseline_processor_us = theirs.processor_us};
}

struct Sums {  // results are summed so that the compiler does not remove the work
  double value = 0;
};

class CoverageBench {
 public:
  CoverageBench(std::size_t n, std::uint64_t seed)
      : field_(make_field(n, seed)), space_({.spacing = h, .box = box()}), octree_(h), random_(seed + 1) {
    Triangulation::Cell_handle hint;
    for (const Vec3& p : field_.states) {
      State state;
      state.at = p;
      octree_.insert(space_.insert(state).id, p);
      hint = plain_.insert(point(p), hint)->cell();
      cloud_.points.push_back(p);
    }
    tree_ = std::make_unique<KdTree>(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  }

  std::vector<BenchRow> run() {
    std::vector<BenchRow> rows;
    query_path(rows);
    query_random(rows);
    insert_path(rows);
    return rows;
  }
  double sum() const { return sums_.value; }
  const BenchTime& insert_time() const { return insert_; }

 private:
  static constexpr int batches = 9;
  Box box() const { return {Vec3::Constant(-field_.half), Vec3::Constant(field_.half)}; }

  template <class Work>
  void batch(BenchTimes& times, std::size_t count, Work&& work) {
    const BenchTime start = bench_time();
    for (std::size_t i = 0; i < count; ++i) sums_.value += work(i);
    times.add(bench_time() - start, static_cast<double>(count));
  }

  // Labels along a path: ours against CGAL's locate from the last cell, the octree against the k-d tree's
  // nearest. Ours keep a walk between queries, as CGAL keeps its hint.
  void query_path(std::vector<BenchRow>& rows) {
    constexpr std::size_t steps = 4000;
    BenchTimes ours, cgal, octree, nano;
    Triangulation::Cell_handle hint;
    PathWalk walk, counted;
    for (int b = 0; b < batches; ++b) {
      const std::vector<Vec3> path = make_path(field_, steps, 0.3 * b);
      batch(ours, steps, [&](std::size_t i) { return static_cast<double>(space_.label(path[i], walk)); });
      batch(cgal, steps, [&](std::size_t i) {
        hint = plain_.locate(point(path[i]), hint);
        return static_cast<double>(hint->vertex(1)->info());
      });
      batch(octree, steps,
            [&](std::size_t i) { return static_cast<double>(octree_.label(path[i], counted)); });
      batch(nano, steps, [&](std::size_t i) { return nearest(path[i]); });
    }
    add(rows, "delaunay query path", "CGAL locate", ours, cgal);
    add(rows, "octree query path", "nanoflann", octree, nano);
  }

  void query_random(std::vector<BenchRow>& rows) {
    constexpr std::size_t count = 1000;
    std::uniform_real_distribution<double> uniform(-field_.half, field_.half);
    BenchTimes ours, cgal, nano, octree;
    for (int b = 0; b < batches; ++b) {
      std::vector<Vec3> q;
      for (std::size_t i = 0; i < count; ++i)
        q.emplace_back(uniform(random_), uniform(random_), uniform(random_));
      batch(ours, count, [&](std::size_t i) { return static_cast<double>(space_.label(q[i])); });
      Triangulation::Cell_handle hint;
      batch(cgal, count, [&](std::size_t i) {
        hint = plain_.locate(point(q[i]), hint);
        return static_cast<double>(hint->vertex(1)->info());
      });
      batch(octree, count, [&](std::size_t i) { return static_cast<double>(octree_.label(q[i])); });
      batch(nano, count, [&](std::size_t i) { return nearest(q[i]); });
    }
    add(rows, "delaunay query random", "CGAL locate", ours, cgal);
    add(rows, "delaunay query random", "nanoflann", ours, nano);
    add(rows, "octree query random", "nanoflann", octree, nano);
  }

  // Inserts a new state every quarter spacing along a path into all three indexes.
  void insert_path(std::vector<BenchRow>& rows) {
    const std::size_t count = std::clamp<std::size_t>(field_.states.size() / 20, 50, 400);
    BenchTimes ours, cgal, octree;
    Triangulation::Cell_handle hint;
    for (int b = 0; b < batches; ++b) {
      const std::vector<Vec3> dense = make_path(field_, count * 25, 0.11 + 0.3 * b);
      std::uniform_real_distribution<double> jitter(-0.05 * h, 0.05 * h);
      std::vector<Vec3> fresh;
      for (std::size_t i = 0; i < count; ++i)
        fresh.push_back(dense[25 * i] + Vec3(jitter(random_), jitter(random_), jitter(random_)));
      batch(cgal, count, [&](std::size_t i) {
        hint = plain_.insert(point(fresh[i]), hint)->cell();
        return hint->vertex(0)->info();
      });
      std::vector<StateId> ids;
      batch(ours, count, [&](std::size_t i) {
        State state;
        state.at = fresh[i];
        ids.push_back(space_.insert(std::move(state)).id);
        return 1.0;
      });
      batch(octree, count, [&](std::size_t i) {
        octree_.insert(ids[i], fresh[i]);
        return 1.0;
      });
    }
    add(rows, "delaunay insert path", "CGAL insert", ours, cgal);
    add(rows, "octree insert", "delaunay insert", octree, ours);
    insert_ = ours.median();
  }

  void add(std::vector<BenchRow>& rows, const char* name, const char* baseline, const BenchTimes& ours,
           const BenchTimes& theirs) const {
    rows.push_back(coverage_row(name, baseline, median(ours.wall), theirs.median(), field_.states.size()));
  }

  double nearest(const Vec3& q) const {
    unsigned index = 0;
    double squared = 0;
    tree_->knnSearch(q.data(), 1, &index, &squared);
    return squared;
  }

  Field field_;
  StateSpace space_;
  OctreeIndex octree_;
  Triangulation plain_;
  Cloud cloud_;
  std::unique_ptr<KdTree> tree_;
  std::mt19937_64 random_;
  Sums sums_;
  BenchTime insert_;
};

}  // namespace

int bench_coverage(const Globals& globals) {
  std::vector<BenchRow> rows;
  Progress progress(globals, "bench coverage");
  double sum = 0;
  const std::vector<std::size_t> sizes{1000, 10'000, 100'000, 1'000'000};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    progress.show(static_cast<double>(i) / static_cast<double>(sizes.size()),
                  fmt::format("{} states", sizes[i]));
    CoverageBench bench(sizes[i], globals.seed);
    for (BenchRow& row : bench.run()) rows.push_back(std::move(row));
    if (sizes[i] <= 100'000)
      for (const RegionCost& cost : bench_regions(sizes[i], globals.seed)) {
        rows.push_back(coverage_row("region labels " + cost.name, "delaunay insert", cost.look_us,
                                    bench.insert_time(), cost.states));
        rows.push_back(coverage_row("regions " + cost.name, "delaunay insert", cost.whole_us,
                                    bench.insert_time(), cost.states));
        sum += cost.sum;
      }
    sum += bench.sum();
  }
  Json out{{"rows", Json::array()}};
  say(globals, fmt::format("{:<24}{:<18}{:>9}{:>12}{:>14}{:>9}", "", "baseline", "n", "ours [us]",
                           "baseline [us]", "ratio"));
  for (const BenchRow& row : rows) {
    out["rows"].push_back(row_json(row, {.scene = "jittered lattice, 6 mm"}));
    say(globals, fmt::format("{:<24}{:<18}{:>9}{:>12.3f}{:>14.3f}{:>9}", row.name, row.baseline, row.n,
                             row.ours_us, row.baseline_us, ratio_text(row)));
  }
  report_agreement(globals, out);
  add_to(out, provenance_keys(), {});
  if (globals.json) print_json(out);
  return std::isfinite(sum) ? 0 : 1;
}

}  // namespace forefeel
