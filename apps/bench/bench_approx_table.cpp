// The tables of `forefeel-bench approx`, as text and as JSON.

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_approx_parts.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/json.hpp"
#include "geometry/common/instruction_set.hpp"

namespace forefeel::bench {
namespace {

std::string short_number(double value, int width) {
  return std::isfinite(value) ? fmt::format("{:{}.3g}", value, width) : fmt::format("{:>{}}", "-", width);
}

std::string table_line(const Measured& m) {
  std::string line =
      fmt::format("{:13} {:4} |   {} {} {} {} {:>9} |", m.method, m.n, short_number(m.refit, 7),
                  short_number(m.update[0], 6), short_number(m.update[1], 6), short_number(m.update[2], 6),
                  short_number(m.evaluate, 9));
  line += fmt::format(" {:10.1e} {:8.1e} {:8.1e} |            ", m.inside.p50, m.inside.p95, m.inside.max);
  for (const Errors& e : m.outside)
    line += std::isfinite(e.p50) ? fmt::format("    {:7.1e}", e.p50) : fmt::format("{:>11}", "-");
  line += " |";
  for (const auto& states : {m.states_for_1, m.states_for_7})
    line += fmt::format(" {:>5}", states ? std::to_string(*states) : "-");
  return line;
}

BenchRow bench_row(const Comparison& r) {
  return {.name = r.name,
          .baseline = r.baseline,
          .ours_us = r.ours,
          .baseline_us = r.theirs.wall_us,
          .error = {r.error.p50, r.error.p95, r.error.max},
          .n = r.n,
          .k = r.k,
          .baseline_processor_us = r.theirs.processor_us};
}

std::string row_line(const Comparison& r) {
  const std::string mark = not_counted(bench_row(r));
  return fmt::format("{:18} {:4} {:>3} {:10.3f} {:>26} {:10.3f} {:>7} {:9.1e} {:9.1e} {:>8}{}", r.name, r.n,
                     r.k ? std::to_string(*r.k) : "-", r.ours, r.baseline, r.theirs.wall_us,
                     mark.empty() ? fmt::format("{:.2f}", r.theirs.wall_us / r.ours) : "-", r.error.p50,
                     r.error.p95, std::isfinite(r.by_refit) ? fmt::format("{:.0f} %", 100 * r.by_refit) : "-",
                     mark.empty() ? "" : "  not counted: " + mark);
}

std::vector<double> numbers(const Errors& e) {
  return {e.p50, e.p95, e.max};
}

struct MethodRow {
  const Case& taken;
  const Measured& m;

  Json updates() const {
    Json all;
    for (std::size_t t = 0; t < 3; ++t) all["k" + std::to_string(replacements[t])] = number(m.update[t]);
    return all;
  }
  std::optional<Json> outside() const {
    if (m.outside.empty()) return {};
    Json all;
    for (std::size_t p = 0; p < m.outside.size(); ++p)
      put(all[fmt::format("mm{:.0f}", 1e3 * taken.outside[p].distance)], "p50,p95,max",
          json_numbers(numbers(m.outside[p])));
    return all;
  }
};

const JsonKeys<Comparison>& comparison_keys() {
  static const JsonKeys<Comparison> keys{
      {"by_refit", "1", "share of the updates that were made anew", &Comparison::by_refit}};
  return keys;
}

const JsonKeys<MethodRow>& method_keys() {
  using R = MethodRow;
  const auto count = [](std::optional<std::size_t> states) { return states ? Json(*states) : Json(); };
  static const JsonKeys<R> keys{
      {"method", "", "bench approx: one row a method and size", [](const R& r) { return r.m.method; }},
      {"n", "", "number of centres", [](const R& r) { return r.m.n; }},
      {"refit_us", "us", "time of a new model", [](const R& r) { return r.m.refit; }},
      {"update_us.KEY", "us", "time to replace k states", &R::updates},
      {"evaluate_us", "us", "time of a force", [](const R& r) { return r.m.evaluate; }},
      {"error.p50,p95,max", "1", "inside the states",
       [](const R& r) { return json_numbers(numbers(r.m.inside)); }},
      {"outside.KEY.p50,p95,max", "1", "at this distance outside", &R::outside},
      {"states_for_1_percent", "", "states that hold 1 %; null: more than were tried",
       [=](const R& r) { return count(r.m.states_for_1); }},
      {"states_for_7_percent", "", "that hold 7 %", [=](const R& r) { return count(r.m.states_for_7); }}};
  return keys;
}

struct Results {
  std::vector<MethodRow> methods;
  const std::vector<std::string>& notes;
};

const JsonKeys<Results>& result_keys() {
  static const JsonKeys<Results> keys{
      json_list<Results, MethodRow>("methods", method_keys(), &Results::methods),
      {"notes", "", "list of lines", [](const Results& r) { return r.notes; }}};
  return keys;
}

}  // namespace

Json document_of(const Case& taken, const std::vector<Comparison>& rows, const std::vector<Measured>& table,
                 const std::vector<std::string>& notes) {
  Json document{{"rows", Json::array()}};
  for (const Comparison& row : rows) {
    Json r = row_json(bench_row(row), {.scene = taken.name, .body = taken.body.get(), .tolerance = 1e-9});
    add_to(r, comparison_keys(), row);
    document["rows"].push_back(std::move(r));
  }
  Results results{{}, notes};
  for (const Measured& m : table) results.methods.push_back({taken, m});
  add_to(document, result_keys(), results);
  add_to(document, instruction_set_keys(), {});
  add_to(document, provenance_keys(), {});
  return document;
}

void print_tables(const Globals& globals, const Case& taken, std::size_t known,
                  const std::vector<Comparison>& rows, const std::vector<Measured>& table) {
  say(globals, fmt::format("{}: {} states, {} instructions, one thread; medians\n", taken.name, known,
                           name(instruction_set_in_use())));
  say(globals, fmt::format("{:18} {:>4} {:>3} {:>10} {:>26} {:>10} {:>7} {:>9} {:>9} {:>8}", "", "n", "k",
                           "ours us", "baseline", "us", "ratio", "error p50", "p95", "by refit"));
  for (const Comparison& row : rows) say(globals, row_line(row));
  say(globals,
      "evaluate: three force components on n centres and the polynomial (r3 linear, hermite-r5 quadratic), "
      "from a "
      "position in metres; ours with the check of its bound, the baseline centre by centre. update, refit: "
      "from the states to the "
      "coefficients, three right-hand sides; ours with the tangent and bound of the model. by refit: "
      "updates that the updater made by a refit, as it does where that is cheaper.");
  std::string head;
  for (const auto& plane : taken.outside) head += fmt::format(" {:>8.0f} mm", 1e3 * plane.distance);
  say(globals,
      fmt::format("\n{:13} {:>4} | us: refit  k = 1      5     20  evaluate | inside p50      p95      "
                  "max | outside p50:{} | states for 1 %, 7 %",
                  "method", "n", head));
  for (const Measured& m : table) say(globals, table_line(m));
  say(globals,
      "inside: within the lattice. outside: of the half up to the front, at the given distance beyond it. "
      "states: the "
      "fewest, of the lattice and of every second, third, fourth and sixth of its planes, whose p95 is "
      "below that; at "
      "the same inside positions, also where a thinned lattice ends before them.");
}

}  // namespace forefeel::bench

namespace forefeel {

DeclaredTable declared_bench_approx() {
  using namespace bench;
  return bench_table("approx", {declared(instruction_set_keys()),
                                below("rows[]", declared(comparison_keys())), declared(result_keys())});
}

}  // namespace forefeel
