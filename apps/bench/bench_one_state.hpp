#pragma once
// Cost of the first state of a large body: time, including the analysis of the matrix, and memory.

#include <memory>
#include <string>
#include <vector>

#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// `forefeel-bench solver SCENE --states 1`.
int bench_one_state(const Globals& globals, std::shared_ptr<const Body> body, double spacing,
                    const std::string& scene);

const JsonKeys<BenchEnd>& solver_machine_keys();  // of all documents of bench solver
std::vector<Declared> declared_one_state();       // keys of the rows, beside those of all benches

}  // namespace forefeel
