#pragma once
// Where the rendered force of a session is compared with a tight solve.

namespace forefeel {

struct JudgingOptions {
  double error_floor = 0.05;      // f0: errors are relative to max(|f|, f0) [N]
  double reference_step = 0.002;  // HIP travel between samples [m]
  double visit_cell = 0;          // side of the cells whose first visits are sampled [m]; 0: the spacing
  int visit_stride = 1;           // of the first visits every so many-th, from the first on
};

// InputError names the key of a value that cannot be used.
void check(const JudgingOptions& options);

// Side of the cells whose first visits are sampled [m].
inline double visit_cell(const JudgingOptions& options, double spacing) {
  return options.visit_cell > 0 ? options.visit_cell : spacing;
}

}  // namespace forefeel
