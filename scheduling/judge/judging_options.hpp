#pragma once
// At which frames the rendered force of a session is compared with a tight solve, and whether the mesh itself is
// judged; how a session is stopped from outside.

#include <atomic>

namespace forefeel {

struct JudgingOptions {
  double error_floor = 0.05;         // f0: errors are relative to max(|f|, f0) [N]
  double reference_step = 0.002;     // HIP travel between samples [m]
  double visit_cell = 0;             // side of the cells whose first visits are sampled [m]; 0: the spacing
  int visit_stride = 1;              // n: every n-th first visit is sampled, from the first on
  bool discretisation_error = true;  // commands measure that of the mesh (solver/equilibrium/mesh_error.hpp)
};

// Throws InputError with the key of an invalid value.
void check(const JudgingOptions& options);

// Side of the cells whose first visits are sampled [m].
inline double visit_cell(const JudgingOptions& options, double spacing) {
  return options.visit_cell > 0 ? options.visit_cell : spacing;
}

struct StopOptions {
  const std::atomic<bool>* interrupted = nullptr;  // once true, the session ends after that frame
  // Once true, an interrupted session no longer waits for references.
  const std::atomic<bool>* hurried = nullptr;
  double patience = 3;  // an interrupted session waits this long for pending references [s]

  bool is_interrupted() const { return interrupted && interrupted->load(std::memory_order_relaxed); }
  bool is_hurried() const { return hurried && hurried->load(std::memory_order_relaxed); }
};

}  // namespace forefeel
