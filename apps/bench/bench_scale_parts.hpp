#pragma once
// Parts of `forefeel-bench scale`: one job at one size, measured at several numbers of threads beside a baseline on as
// many. Times are by the wall, the shortest of a few rounds.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/bench_row.hpp"
#include "apps/picture/scratch_folder.hpp"
#include "geometry/common/types.hpp"
#include "solver/body/body.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {

struct ScaleRow {
  BenchRow row;  // times of one of its n items: a state, or a point
  std::string scene = {};
  std::shared_ptr<const Body> body = {};  // null: none
  int threads = 1;
  double serial = unknown;                     // share s of t(p) = t(1) (s + (1 - s) / p)
  std::optional<ParallelTimes> parallel = {};  // of generate
  double seconds() const { return 1e-6 * row.ours_us * static_cast<double>(row.n); }
};

// The share of the time that more threads do not shorten, by least squares over the rows of one job: t = a + b / p,
// s = a / (a + b), held to [0, 1]. Unknown with fewer than two numbers of threads.
double fitted_serial_share(const std::vector<ScaleRow>& rows);

// SciPy in a child process, on as many threads as it can use of those given. Its tables are exchanged in a folder.
class SciPy {
 public:
  SciPy();
  bool there() const { return !python_.empty(); }
  struct Found {
    double seconds = unknown;         // without reading and writing
    std::vector<double> values = {};  // empty: it failed
  };
  // Distances of q from the nearest of `at`, by a KD-tree.
  Found nearest(const std::vector<Vec3>& at, const std::vector<Vec3>& q, int threads) const;
  // RBFInterpolator of r^3 and a linear polynomial, 50 neighbours: #q x 3.
  Found forces(const std::vector<Vec3>& at, const std::vector<Vec3>& force, const std::vector<Vec3>& q) const;

 private:
  Found run(const std::string& job, int threads) const;
  void write(const char* name, const std::vector<Vec3>& rows) const;

  ScratchFolder folder_;
  std::string python_;  // empty: none that has SciPy
};

// A lattice of this spacing [m] over the box; the baseline assembles and factorises the body's matrix on as many
// threads, one factor each. error: of the forces, from those of the first number of threads.
std::vector<ScaleRow> scale_generate(const std::string& name, const std::string& scene,
                                     const std::shared_ptr<const Body>& body, const LatticeOptions& lattice,
                                     const std::vector<int>& threads);
// Random states in a cube, read from a CSV file. error: of the radius of the largest hole, from SciPy's distance.
std::vector<ScaleRow> scale_classify(std::size_t states, std::uint64_t seed, const std::vector<int>& threads,
                                     const SciPy& scipy);
// Forces at random points from random states, cubic, 50 nearest. error: from SciPy's, over the largest force.
std::vector<ScaleRow> scale_evaluate(std::size_t states, std::size_t points, std::uint64_t seed,
                                     const std::vector<int>& threads, const SciPy& scipy);

}  // namespace forefeel
