#include "apps/generate/generate_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

double bytes_of_lattice(const Scene& scene) {
  const Eigen::Array3d along = (scene.space.box.size() / scene.space.spacing).array().floor() + 1;
  const double positions = along.prod();
  constexpr double of_index = 48;  // in a set
  const double of_position = sizeof(State) + 3 * of_index;
  if (is_linear(*scene.body)) return positions * of_position;
  const double unknowns = 3 * static_cast<double>(scene.body->mesh.nodes.size());
  const double of_coarse = sizeof(State) + of_index + 4 * sizeof(double) * unknowns;
  const double coarse = along.min(0.5 * along + 1.5).prod();  // every second plane, and both ends
  return positions * of_position + coarse * of_coarse;
}

void check_memory_of_lattice(const Scene& scene, double bytes_left) {
  const double bytes = bytes_of_lattice(scene);
  if (bytes <= bytes_left) return;
  throw InputError(
      scene.written.box_place,
      fmt::format("a lattice of {:g} m in it would take {} of memory, but {} are left; expected a "
                  "larger spacing, or a smaller box",
                  scene.space.spacing, bytes_in_words(bytes), bytes_in_words(bytes_left)));
}

void check_memory_of_threads(const Scene& scene, int threads, double bytes_left) {
  constexpr int few = 8;               // up to this number of threads, no memory check is made
  constexpr double of_thread = 256e3;  // stack as far as it is used, buffers of the allocator
  if (threads <= few) return;
  const double solver = is_linear(*scene.body)
                            ? 0
                            : static_cast<double>(SolverBasis(scene.body).bytes_per_solver(scene.kept.jet));
  const double bytes = threads * (solver + of_thread);
  if (bytes <= bytes_left) return;
  throw InputError("--threads", fmt::format("is {}, and the solvers of so many threads take about {} of "
                                            "memory, {} are free, expected at most {:g}",
                                            threads, bytes_in_words(bytes), bytes_in_words(bytes_left),
                                            std::max<double>(few, std::floor(threads * bytes_left / bytes))));
}

}  // namespace forefeel
