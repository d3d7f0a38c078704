#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/states/jet_columns.hpp"
#include "geometry/states/named_columns.hpp"
#include "geometry/states/named_rows.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

Mat3 read_stiffness(NamedRows& in) {
  Mat3 stiffness;
  int known = 0;
  for (unsigned i = 0; i < 9; ++i) {
    stiffness(i / 3, i % 3) = in.optional(stiffness_columns[i]);
    known += std::isfinite(stiffness(i / 3, i % 3));
  }
  if (known != 0 && known != 9)
    in.fail("the stiffness is only partly known, expected all of k11 to k33 or none");
  return stiffness;
}

std::shared_ptr<const EnergyJet> read_jet(NamedRows& in) {
  JetCells cells = cells_of(nullptr);
  for (std::size_t i = 0; i < jet_size && in.has(jet_names()[i]); ++i)
    cells.coefficients[i] = in.optional(jet_names()[i]);
  cells.limit = in.distance("limit");
  JetOfCells read = jet_of(cells);
  if (!read.problem.empty()) in.fail("column " + read.problem);
  return std::move(read.jet);
}

bool has_sites(NamedRows& in) {
  const int found = in.has("sx") + in.has("sy") + in.has("sz");
  if (found != 0 && found != 3)
    in.fail(fmt::format("{} of the columns sx, sy, sz, expected all or none", found));
  return found != 0;
}

// All three cells empty: the state has no site.
Vec3 read_site(NamedRows& in) {
  const Vec3 site(in.optional("sx"), in.optional("sy"), in.optional("sz"));
  if (site.array().isNaN().all()) return site;
  if (!site.allFinite() || site.cwiseAbs().maxCoeff() > largest_number)
    in.fail("the site is not a place, expected three numbers in sx, sy and sz, or none");
  return site;
}

SolveStatus read_status(NamedRows& in) {
  if (in.has("status")) {
    const auto status = solve_status(in.text("status"));
    if (!status)
      in.fail(fmt::format("status '{:.40}' is unknown, expected converged, measured, diverged, …",
                          in.text("status")));
    return *status;
  }
  if (!in.has("converged")) return SolveStatus::measured;
  const std::string word = lower_case(in.text("converged"));
  if (word == "1" || word == "true") return SolveStatus::converged;
  if (word == "0" || word == "false") return SolveStatus::diverged;
  in.fail(fmt::format("converged '{:.40}', expected 1, 0, true or false", word));
}

// Squares must not overflow.
void check_size(const NamedRows& in, const State& state) {
  if (std::max(state.at.cwiseAbs().maxCoeff(), state.force.cwiseAbs().maxCoeff()) > largest_number ||
      (state.has_stiffness() && state.stiffness.cwiseAbs().maxCoeff() > largest_number))
    in.fail(fmt::format("a position, force or stiffness is above {:g} in size, expected SI units",
                        largest_number));
}

// Rows with at least x,y,z: with fx,fy,fz, with one value, or alone.
std::vector<State> read_rows(NamedRows& in) {
  const auto given =
      std::ranges::count_if(stiffness_columns, [&](const char* column) { return in.has(column); });
  if (given != 0 && given != 9)
    in.fail(fmt::format("{} of the nine columns k11 to k33, expected all or none", given));
  if (const std::string missing = missing_jet_column([&](const std::string& name) { return in.has(name); });
      !missing.empty())
    in.fail(missing);
  const bool jets = in.has(jet_names().front()), sites = has_sites(in);
  std::vector<State> states = in.read_all<State>([&](NamedRows& row) {
    State state;
    state.at = row.vector("x", "y", "z");
    state.solve.status = read_status(row);
    if (!row.value().empty())
      state.force = {row.finite(row.value()), 0, 0};
    else if (!row.has("fx"))
      state.force.setConstant(unknown);
    else if (state.usable())
      state.force = row.vector("fx", "fy", "fz");
    else
      state.force = {row.optional("fx"), row.optional("fy"), row.optional("fz")};
    if (sites) state.site = read_site(row);
    if (given == 9) state.stiffness = read_stiffness(row);
    check_size(row, state);
    if (row.has("h")) {
      state.spacing = row.optional("h");
      if (state.spacing <= 0)
        row.fail(fmt::format("column h: {} is not a spacing, expected a positive number", state.spacing));
    }
    if (row.has("energy")) state.energy = row.optional("energy");
    if (jets) state.jet = read_jet(row);
    return state;
  });
  if (states.empty())
    throw InputError({.file = in.name()}, "holds no states, expected rows after the header line");
  return states;
}

}  // namespace

std::vector<State> read_states_csv(const std::filesystem::path& file) {
  NamedRows in(file, required_columns, false);
  return read_rows(in);
}

namespace {
StateTable table_of(NamedRows& in) {
  StateTable table{.states = read_rows(in), .value = in.value()};
  table.tells = !in.value().empty() ? Tells::value : in.has("fx") ? Tells::force : Tells::places;
  return table;
}
}  // namespace

StateTable read_table_csv(const std::filesystem::path& file) {
  NamedRows in(file);
  return table_of(in);
}

StateTable read_table_csv(const std::filesystem::path& file, const NamedColumns& columns) {
  NamedRows in(file, columns);
  return table_of(in);
}

NamedColumns named_columns(std::string_view text) {
  NamedColumns names;
  std::set<std::string_view> seen;
  for (bool more = true; more;) {
    const std::size_t end = text.find(',');
    const std::string_view name = trimmed(text.substr(0, end));
    names.emplace_back(name);
    seen.insert(name.substr(name.starts_with('-') ? 1 : 0));
    more = end != std::string_view::npos;
    if (more) text.remove_prefix(end + 1);
  }
  const bool meant = names.size() == 3 || names.size() == 4 || names.size() == 6;
  if (!meant || seen.size() != names.size() || seen.contains(""))
    throw InputError("--columns",
                     fmt::format("names {} columns, expected different ones of x, y and z alone, with one "
                                 "value, or with fx, fy and fz",
                                 names.size()));
  return names;
}

std::vector<Vec3> read_points_csv(const std::filesystem::path& file) {
  NamedRows in(file, place_columns, true);
  const std::vector<Vec3> points =
      in.read_all<Vec3>([](NamedRows& row) { return row.vector("x", "y", "z"); });
  if (points.empty()) throw InputError({.file = in.name()}, "holds no points, expected rows x,y,z");
  return points;
}

std::vector<SitedPoint> read_sited_points_csv(const std::filesystem::path& file) {
  constexpr std::array<const char*, 6> required{"sx", "sy", "sz", "x", "y", "z"};
  NamedRows in(file, required, true);
  const std::vector<SitedPoint> points = in.read_all<SitedPoint>([](NamedRows& row) {
    return SitedPoint{row.vector("sx", "sy", "sz"), row.vector("x", "y", "z")};
  });
  if (points.empty()) throw InputError({.file = in.name()}, "holds no points, expected rows sx,sy,sz,x,y,z");
  return points;
}

namespace {

Tells told_by(const StateFileHeader& header) {
  const auto note = header.notes.find(tells_note);
  return note == header.notes.end() ? Tells::force : note->second == "value" ? Tells::value : Tells::places;
}

void check_told(const std::filesystem::path& file, Tells told, Tells least) {
  if (told < least)
    throw InputError(
        {.file = file.string()},
        fmt::format("holds {}, expected {}",
                    told == Tells::value ? "one value at each place" : "places alone",
                    least == Tells::force ? "forces: columns fx,fy,fz" : "a value or a force at each"));
}

}  // namespace

LoadedStates load_states(const std::filesystem::path& file, Tells least) {
  LoadedStates loaded;
  const std::string content_start = read_start(file, 16);
  if (content_start.starts_with("SQLite format 3")) {
    const StateFile states = StateFile::open_read_only(file);
    states.check_pages();  // damage is found before the caller writes anything
    loaded.header = states.header();
    loaded.states = states.read_all();
    loaded.damaged = states.damaged();
    loaded.tells = told_by(loaded.header);
    if (const auto name = loaded.header.notes.find(value_note); name != loaded.header.notes.end())
      loaded.value = name->second;
    check_told(file, loaded.tells, least);
    return loaded;
  }
  if (content_start.find('\0') != std::string::npos)
    throw InputError({.file = file.string()}, "is neither a state file nor a CSV of states in UTF-8");
  if (least == Tells::force) {
    loaded.states = read_states_csv(file);
  } else {
    StateTable table = read_table_csv(file);
    loaded.states = std::move(table.states);
    loaded.tells = table.tells;
    loaded.value = table.value;
    check_told(file, loaded.tells, least);
  }
  loaded.header.box = {loaded.states.front().at, loaded.states.front().at};
  for (const State& state : loaded.states) {
    loaded.header.box.low = loaded.header.box.low.cwiseMin(state.at);
    loaded.header.box.high = loaded.header.box.high.cwiseMax(state.at);
    if (std::isfinite(state.spacing) && !(loaded.header.spacing >= state.spacing))
      loaded.header.spacing = state.spacing;
  }
  return loaded;
}

}  // namespace forefeel
