#pragma once
// Times of one model in `forefeel-bench approx`, each compared with a baseline measured in the same run.

#include <vector>

#include "approx/model/rbf_fit.hpp"
#include "apps/bench/bench_approx_parts.hpp"
#include "apps/bench/bench_row.hpp"

namespace forefeel::bench {

// Time of one force(x), mean of `repeats`.
template <class Force>
BenchTime evaluation_time(const Globals& globals, const Force& force, const std::vector<Vec3>& at,
                          int repeats) {
  Vec3 sum = Vec3::Zero();
  const Vec3 *next = at.data(),
             *end = next + at.size();  // not an index modulo the size, whose time would count
  const BenchTime start = bench_time();
  for (int i = 0; i < repeats; ++i) {
    sum += force(*next);
    if (++next == end) next = at.data();
  }
  const BenchTime took = bench_time() - start;
  if (!sum.allFinite()) warn(globals, "an evaluation was not finite");
  return {took.wall_us / repeats, took.processor_us / repeats};
}
template <class Force>
double evaluation_us(const Globals& globals, const Force& force, const std::vector<Vec3>& at, int repeats) {
  return evaluation_time(globals, force, at, repeats).wall_us;
}

// Times refit, update and evaluation of a model with these options. The model holds the first n samples of the pool;
// updates replace them by the other samples. Fills the times of `m`, whose method and errors must be set before, and
// appends the comparisons to `rows`.
void time_model(const Globals& globals, const Case& taken, const std::vector<Sample>& pool,
                const ModelOptions& options, Measured& m, std::vector<Comparison>& rows);

// The same of a model of jets of the states of `space`. refit: choice and copy of the n jets; update: with k states
// that are new to it, each held against every jet. The baseline is a Hermite model of 25 states.
void time_jets(const Globals& globals, const Case& taken, const StateSpace& space,
               const ModelOptions& options, Measured& m, std::vector<Comparison>& rows);

}  // namespace forefeel::bench
