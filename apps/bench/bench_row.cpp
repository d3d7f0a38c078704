#include "apps/bench/bench_row.hpp"

#include <chrono>

#include "apps/console/json.hpp"
#include "solver/body/law_table.hpp"

namespace forefeel {

nlohmann::ordered_json row_json(const BenchRow& row, const BenchSubject& subject) {
  using Json = nlohmann::ordered_json;
  return {{"name", row.name},
          {"baseline", row.baseline},
          {"ratio", number(row.baseline_us / row.ours_us)},
          {"ours_us", number(row.ours_us)},
          {"baseline_us", number(row.baseline_us)},
          {"error", row.error},
          {"n", row.n},
          {"k", row.k ? Json(*row.k) : Json()},
          {"scene", subject.scene},
          {"law", subject.body ? Json(name(subject.body->material.law)) : Json()},
          {"elements", subject.body ? Json(subject.body->mesh.tets.size()) : Json()},
          {"threads", subject.threads},
          {"tolerance", number(subject.tolerance)}};
}

nlohmann::ordered_json errors_json(double p50, double p95, double max) {
  return {{"p50", number(p50)}, {"p95", number(p95)}, {"max", number(max)}};
}

double now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace forefeel
