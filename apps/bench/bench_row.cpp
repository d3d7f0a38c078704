#include "apps/bench/bench_row.hpp"

#include <fmt/format.h>

#include <time.h>

#include <chrono>
#include <filesystem>

#include "apps/bench/bench.hpp"
#include "apps/console/provenance.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/instruction_set.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/common/result_folder.hpp"
#include "solver/body/law.hpp"

namespace forefeel {
namespace {

struct RowAndSubject {
  const BenchRow& row;
  const BenchSubject& subject;
};

const JsonKeys<RowAndSubject>& common_keys() {
  using R = RowAndSubject;
  const auto of_body = [](auto get) {
    return [get](const R& r) { return r.subject.body ? Json(get(*r.subject.body)) : Json(); };
  };
  static const JsonKeys<R> keys{
      {"name", "", "what is measured", [](const R& r) { return r.row.name; }},
      {"baseline", "", "what it is compared with, in the same run",
       [](const R& r) { return r.row.baseline; }},
      {"ratio", "1", "time of the baseline over ours; null: not counted",
       [](const R& r) {
         return not_counted(r.row).empty() ? Json(r.row.baseline_us / r.row.ours_us) : Json();
       }},
      {"ours_us", "us", "time of ours", [](const R& r) { return r.row.ours_us; }},
      {"baseline_us", "us", "time of the baseline", [](const R& r) { return r.row.baseline_us; }},
      {"baseline_processor_us", "us", "the same by the processor time of its thread; null: not measured",
       [](const R& r) { return r.row.baseline_processor_us; }},
      {"not_counted", "", "why the ratio is not counted; empty: it is",
       [](const R& r) { return not_counted(r.row); }},
      {"error.p50,p95,max", "1", "relative error of ours, or difference of the forces",
       [](const R& r) { return json_numbers(r.row.error); }},
      {"n", "", "number of states or centres", [](const R& r) { return r.row.n; }},
      {"k", "", "states replaced at once; null: none",
       [](const R& r) { return r.row.k ? Json(*r.row.k) : Json(); }},
      {"scene", "", "measured on", [](const R& r) { return r.subject.scene; }},
      {"law", "", "of its material", of_body([](const Body& body) { return name(body.material.law); })},
      {"elements", "", "of its mesh", of_body([](const Body& body) { return body.mesh.tets.size(); })},
      {"threads", "", "used by both", [](const R& r) { return r.subject.threads; }},
      {"tolerance", "1", "of the solves behind it", [](const R& r) { return r.subject.tolerance; }}};
  return keys;
}

}  // namespace

std::string not_counted(const BenchRow& row) {
  if (row.baseline_failed > 0) return fmt::format("{} solves of the baseline failed", row.baseline_failed);
  if (row.baseline_processor_us < row.baseline_us / 1.2)
    return fmt::format("the baseline waited for a processor for {:.0f} % of its time",
                       100 * (1 - row.baseline_processor_us / row.baseline_us));
  if (row.baseline_processor_us > 1.2 * row.baseline_us) return "the baseline used several processors";
  return {};
}

std::vector<double> p50_p95_max(const std::vector<double>& values) {
  return {quantile_of(values, 0.5), quantile_of(values, 0.95), quantile_of(values, 1)};
}

Json row_json(const BenchRow& row, const BenchSubject& subject) {
  return document_of(common_keys(), RowAndSubject{row, subject});
}

JsonKey<BenchEnd> instruction_set_key(std::string_view name) {
  return {"instruction_set", "", "of the loops", [name](const BenchEnd&) { return name; }};
}

const JsonKeys<BenchEnd>& instruction_set_keys() {
  static const JsonKeys<BenchEnd> keys{instruction_set_key(name(instruction_set_in_use()))};
  return keys;
}

const JsonKeys<BenchEnd>& provenance_keys() {
  static const JsonKeys<BenchEnd> keys{{"provenance.KEY", "", "program, machine and inputs",
                                        [](const BenchEnd& end) { return provenance(end.scene_hash); }}};
  return keys;
}

DeclaredTable bench_table(const std::string& name, std::initializer_list<std::vector<Declared>> parts) {
  DeclaredTable table{"bench_" + name + ".json", "Of forefeel-bench " + name + " --json.",
                      below("rows[]", declared(common_keys()))};
  const auto add = [&](const std::vector<Declared>& rows) {
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
  };
  add(declared(provenance_keys()));
  for (const std::vector<Declared>& rows : parts) add(rows);
  return table;
}

std::vector<DeclaredTable> declared_bench_json() {
  return {declared_bench_approx(), declared_bench_solver(), declared_bench_coverage(),
          declared_bench_switch(), declared_bench_loop(),   declared_bench_jet(),
          declared_bench_truth(),  declared_bench_scale()};
}

void claim_bench_folder(const std::string& folder, const std::vector<std::string>& files) {
  if (folder.empty()) return;
  std::error_code failed;
  const bool there = std::filesystem::exists(folder, failed);
  std::filesystem::create_directories(folder, failed);
  if (!std::filesystem::is_directory(folder, failed))
    throw InputError(folder, fmt::format("{}, expected a folder for {}",
                                         there ? "is a file" : "cannot be made", fmt::join(files, " and ")));
  claim_folder(folder, files);
}

BenchTime BenchTimes::median() const {
  return {forefeel::median(wall), forefeel::median(processor)};
}

std::string ratio_text(const BenchRow& row) {
  const std::string mark = not_counted(row);
  return mark.empty() ? fmt::format("{:.3g}", row.baseline_us / row.ours_us) : "-, not counted: " + mark;
}

BenchTime bench_time() {
  timespec processor{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &processor);
  return {now_us(),
          1e6 * static_cast<double>(processor.tv_sec) + 1e-3 * static_cast<double>(processor.tv_nsec)};
}

double now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace forefeel
