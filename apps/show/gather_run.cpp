#include "apps/show/gather_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/common/dispatch_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_path = 6000;  // positions of the path that are kept

Label label_named(std::string_view text) {
  for (const Label label : {Label::safe, Label::sparse, Label::gap})
    if (name(label) == text) return label;
  return Label::blank;
}

ShownRun read_path(const fs::path& file) {
  const CsvText table = CsvText::read(file, "a file of a run");
  ShownRun run;
  run.frames = table.rows();
  if (table.rows() == 0)
    throw InputError({.file = file.string()}, "holds no frames, expected columns t,x,y,z,fx,fy,fz");
  const auto vector = [&](std::size_t row, const std::array<const char*, 3>& columns) {
    return Vec3(table.number(row, columns[0]), table.number(row, columns[1]), table.number(row, columns[2]));
  };
  const std::size_t stride = (table.rows() + most_path - 1) / most_path;
  double error = unknown;  // the last one sampled since the position that was kept before
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (const double here = table.number(row, "error"); std::isfinite(here)) error = here;
    if (row % stride != 0 && row + 1 != table.rows()) continue;
    ShownFrame frame{.t = table.number(row, "t"),
                     .at = vector(row, {"x", "y", "z"}),
                     .sent = vector(row, {"fx", "fy", "fz"}),
                     .label = label_named(table.text(row, "label")),
                     .error = error,
                     .known = table.number(row, "known"),
                     .trusted = table.number(row, "trusted") > 0};
    error = unknown;
    if (!std::isfinite(frame.t) || !frame.at.allFinite())
      throw InputError({.file = file.string(), .line = table.line(row)},
                       "holds no time and position, expected numbers in t, x, y, z");
    if (!frame.sent.allFinite()) frame.sent.setZero();
    if (!std::isfinite(frame.known)) frame.known = 0;
    run.path.push_back(frame);
  }
  return run;
}

using At = std::array<double, 3>;
At key(const Vec3& at) {
  return {at.x(), at.y(), at.z()};
}

// When each state became known; what failed becomes a state without a force.
void take_dispatch(const fs::path& file, std::vector<ShownState>& states) {
  std::map<At, double> known;
  for (const DispatchRow& row : read_dispatch(file)) {
    if (row.became_known()) known[key(row.at)] = std::isfinite(row.known) ? row.known : row.finished;
    if (row.status != "failed" || !row.at.allFinite()) continue;
    ShownState failed;
    failed.state.at = row.at;
    failed.state.solve.status = SolveStatus::diverged;
    failed.known = row.finished;
    states.push_back(failed);
  }
  for (ShownState& s : states)
    if (const auto found = known.find(key(s.state.at)); found != known.end() && s.state.usable())
      s.known = found->second;
}

// What states.csv does not hold: displacements and how each solve ended.
void take_state_file(const fs::path& file, RunFolder& run) {
  LoadedStates loaded = load_states(file);
  run.identity = loaded.header.identity;
  run.spacing = loaded.header.spacing;
  if (loaded.header.box.size().minCoeff() > 0) run.box = loaded.header.box;
  std::map<At, const State*> solved;
  for (const State& state : loaded.states) solved[key(state.at)] = &state;
  for (ShownState& s : run.states)
    if (const auto found = solved.find(key(s.state.at)); found != solved.end() && found->second->usable())
      s.state = *found->second;
}

void take_summary(const fs::path& file, RunFolder& run) {
  std::ifstream in(file);
  if (!in) return;
  const nlohmann::json summary = nlohmann::json::parse(in, nullptr, false);
  if (!summary.is_object()) return;
  if (summary.contains("spacing") && summary["spacing"].is_number())
    run.spacing = summary["spacing"].get<double>();
  if (summary.contains("provenance")) run.made_by = made_by(summary["provenance"].dump());
}

}  // namespace

bool is_run_folder(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / "frames.csv", error);
}

RunFolder read_run(const fs::path& folder) {
  RunFolder run;
  run.folder = folder;
  run.run = read_path(folder / "frames.csv");
  if (fs::exists(folder / "states.csv"))
    for (State& state : read_states_csv(folder / "states.csv")) {
      run.states.emplace_back();
      run.states.back().state = std::move(state);
    }
  if (fs::exists(folder / "session.states")) take_state_file(folder / "session.states", run);
  if (fs::exists(folder / "dispatch.csv")) take_dispatch(folder / "dispatch.csv", run.states);
  take_summary(folder / "summary.json", run);
  return run;
}

}  // namespace forefeel
