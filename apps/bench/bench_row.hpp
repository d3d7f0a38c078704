#pragma once
// What all benches share: the keys of --json (document_keys.hpp) and the clock. A bench declares its own keys where it
// fills them.

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/console/document_keys.hpp"
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
  std::vector<double> error;            // p50, p95, max
  std::size_t n = 0;
  std::optional<std::size_t> k = {};
  double baseline_processor_us = unknown;  // processor time of its thread; NaN: not measured
  std::size_t baseline_failed = 0;         // solves of the baseline that failed
};
// Why the ratio of a row does not count: its baseline waited for a processor for over 20 % of its time, or failed.
// Empty: it counts.
std::string not_counted(const BenchRow& row);

std::vector<double> p50_p95_max(const std::vector<double>& values);
Json row_json(const BenchRow& row, const BenchSubject& subject);

// What the documents end with.
struct BenchEnd {
  std::string scene_hash = "";
};
JsonKey<BenchEnd> instruction_set_key(std::string_view name);
const JsonKeys<BenchEnd>& instruction_set_keys();  // of our own loops
const JsonKeys<BenchEnd>& provenance_keys();

// The help of `forefeel-bench NAME --json`: the keys of all benches, then these.
DeclaredTable bench_table(const std::string& name, std::initializer_list<std::vector<Declared>> parts);

// Makes the folder and marks these files as ours (result_folder.hpp). Nothing for "". InputError if it cannot be one.
void claim_bench_folder(const std::string& folder, const std::vector<std::string>& files);

double now_us();  // of a steady clock [us]

// Wall time, and the processor time of the calling thread.
struct BenchTime {
  double wall_us = 0, processor_us = 0;
  friend BenchTime operator-(const BenchTime& a, const BenchTime& b) {
    return {a.wall_us - b.wall_us, a.processor_us - b.processor_us};
  }
};
BenchTime bench_time();

// Repeated times of one piece of work [us].
struct BenchTimes {
  std::vector<double> wall, processor;
  void add(const BenchTime& took, double pieces = 1) {
    wall.push_back(took.wall_us / pieces);
    processor.push_back(took.processor_us / pieces);
  }
  void add(const BenchTimes& more) {
    wall.insert(wall.end(), more.wall.begin(), more.wall.end());
    processor.insert(processor.end(), more.processor.begin(), more.processor.end());
  }
  BenchTime median() const;  // of each
};
// The ratio as text, or "-" and the reason why it is not counted.
std::string ratio_text(const BenchRow& row);

}  // namespace forefeel
