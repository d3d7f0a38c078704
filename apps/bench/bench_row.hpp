#pragma once
// What the rows of all benches share: the keys of --json, and the clock.

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// What a bench measures on. body: null if there is none; tolerance: of the solves behind it, NaN for none.
struct BenchSubject {
  std::string scene;
  const Body* body = nullptr;
  int threads = 1;
  double tolerance = unknown;
};

struct BenchRow {
  std::string name, baseline;           // "update r3", "own refit"
  double ours_us = 0, baseline_us = 0;  // [us]
  nlohmann::ordered_json error;         // p50, p95, max
  std::size_t n = 0;
  std::optional<std::size_t> k = {};
};

// ratio is baseline / ours.
nlohmann::ordered_json row_json(const BenchRow& row, const BenchSubject& subject);
nlohmann::ordered_json errors_json(double p50, double p95, double max);

double now_us();  // of a steady clock [us]

}  // namespace forefeel
