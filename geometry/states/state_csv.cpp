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
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

constexpr std::array<const char*, 6> required_columns{"x", "y", "z", "fx", "fy", "fz"};
constexpr std::array<const char*, 3> place_columns{"x", "y", "z"};

// A CSV file with a header line: the cells of the current row by the names of their columns.
class NamedRows {
 public:
  // required: columns that must be there, and their order in a file without a header line (if that is allowed).
  NamedRows(const std::filesystem::path& file, std::span<const char* const> required, bool header_optional)
      : content_(read_text_file(file)), rows_(content_, file.string()) {
    if (!rows_.next())
      throw InputError({.file = rows_.name()},
                       fmt::format("holds no header line, expected {}", fmt::join(required, ",")));
    if (header_optional && only_numbers())
      take_order(required);
    else
      read_header(required);
  }
  // Columns of required_columns, or x,y,z with at most one other: its name is value() then. Without a header line three
  // or four numbers.
  explicit NamedRows(const std::filesystem::path& file)
      : content_(read_text_file(file)), rows_(content_, file.string()) {
    if (!rows_.next())
      throw InputError({.file = rows_.name()}, "holds no row, expected x,y,z or x,y,z,VALUE");
    const std::vector<std::string_view> cells(rows_.cells().begin(), rows_.cells().end());
    if ((cells.size() == 3 || cells.size() == 4) && only_numbers()) {
      take_order(place_columns);
      if (cells.size() == 4) columns_[value_ = "value"] = 3, width_ = 4;
      return;
    }
    const auto is_force = [](std::string_view name) { return name == "fx" || name == "fy" || name == "fz"; };
    std::vector<std::string_view> others;
    std::ranges::copy_if(cells, std::back_inserter(others), [](std::string_view name) {
      return std::ranges::find(place_columns, name) == place_columns.end() && name != "h";
    });
    const bool bare = others.size() < 2 && std::ranges::none_of(others, is_force);
    read_header(bare ? std::span<const char* const>(place_columns) : required_columns);
    if (bare && !others.empty()) value_ = others[0];
  }
  // Only these columns, by the names of required_columns.
  NamedRows(const std::filesystem::path& file, const NamedColumns& given)
      : content_(read_text_file(file)), rows_(content_, file.string()) {
    if (!rows_.next()) throw InputError({.file = rows_.name()}, "holds no header line, expected one");
    check_separator();
    const auto cells = rows_.cells();
    width_ = cells.size();
    if (given.size() == 4) value_ = given[3].substr(given[3].starts_with('-') ? 1 : 0);
    for (std::size_t k = 0; k < given.size(); ++k) {
      const bool turned = given[k].starts_with('-');
      const std::string_view name = std::string_view(given[k]).substr(turned ? 1 : 0);
      const auto called = [&](std::string_view cell) { return trimmed(cell) == name; };
      const auto found = std::ranges::find_if(cells, called);
      if (found == cells.end())
        fail(fmt::format("no column {:.40} of --columns, the header has {:.300}", name,
                         fmt::join(cells, ",")));
      if (std::ranges::count_if(cells, called) > 1) fail(fmt::format("column {:.40} is there twice", name));
      const std::string meant = k == 3 && given.size() == 4 ? value_ : required_columns[k];
      columns_[meant] = static_cast<std::size_t>(found - cells.begin());
      if (turned) turned_.insert(meant);
    }
  }

  bool next() {
    if (!rows_.next()) return false;
    if (rows_.cells().size() != width_)
      fail(fmt::format("{} columns, expected {}", rows_.cells().size(), width_));
    return true;
  }

  bool has(const std::string& column) const { return columns_.contains(column); }
  std::string_view text(const std::string& column) const { return rows_.cells()[columns_.at(column)]; }

  double finite(const std::string& column) const {
    double value = 0;
    if (!parse_real(text(column), value))
      fail(fmt::format("column {}: '{:.40}' is not a number", column, text(column)));
    if (!std::isfinite(value)) fail(fmt::format("column {}: '{:.40}' is not finite", column, text(column)));
    return turned_.contains(column) ? -value : value;
  }
  // Empty or nan: unknown.
  double optional(const std::string& column) const {
    if (text(column).empty() || lower_case(text(column)) == "nan") return unknown;
    return finite(column);
  }
  // The same, but a distance may be infinite.
  double distance(const std::string& column) const {
    const std::string word = lower_case(text(column));
    return word == "inf" || word == "infinity" ? std::numeric_limits<double>::infinity() : optional(column);
  }
  Vec3 vector(const char* x, const char* y, const char* z) const {
    const double a = finite(x), b = finite(y), c = finite(z);
    return {a, b, c};
  }
  [[noreturn]] void fail(const std::string& problem) const { rows_.fail(problem); }
  const std::string& name() const { return rows_.name(); }

  const std::string& value() const { return value_; }  // the only column beside x,y,z; empty: none

 private:
  bool only_numbers() const {
    double number = 0;
    return std::ranges::all_of(rows_.cells(),
                               [&](std::string_view cell) { return parse_real(cell, number); });
  }
  // The row at hand is the first one, its columns are these.
  void take_order(std::span<const char* const> names) {
    for (std::size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
    width_ = names.size();
    rows_.again();
  }
  void check_separator() const {
    const auto cells = rows_.cells();
    if (cells.size() == 1 && cells[0].find_first_of(";\t") != std::string_view::npos)
      fail("columns are not separated by commas, expected a comma-separated file");
  }

  void read_header(std::span<const char* const> required) {
    check_separator();
    const auto cells = rows_.cells();
    std::string_view twice;
    width_ = cells.size();
    for (std::size_t i = 0; i < width_; ++i)
      if (!columns_.emplace(std::string(cells[i]), i).second) twice = cells[i];
    for (const char* column : required)
      if (!columns_.contains(column))
        fail(fmt::format(
            "no column {}, expected a header line with {}{}; this one begins with '{:.40}'", column,
            fmt::join(required, ","),
            required.front() == required_columns.front() && required.size() == 6
                ? " (import --columns takes other names; classify and import take x,y,z alone, or "
                  "with one value)"
                : "",
            cells[0]));
    if (!twice.empty()) fail(fmt::format("column {:.40} is there twice", twice));
  }

  std::string content_;
  CsvRows rows_;
  std::map<std::string, std::size_t> columns_;
  std::string value_;
  std::set<std::string> turned_;  // columns of the other sign
  std::size_t width_ = 0;
};

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
  std::vector<State> states;
  while (in.next()) {
    State state;
    state.at = in.vector("x", "y", "z");
    state.solve.status = read_status(in);
    if (!in.value().empty())
      state.force = {in.finite(in.value()), 0, 0};
    else if (!in.has("fx"))
      state.force.setConstant(unknown);
    else if (state.usable())
      state.force = in.vector("fx", "fy", "fz");
    else
      state.force = {in.optional("fx"), in.optional("fy"), in.optional("fz")};
    if (sites) state.site = read_site(in);
    if (given == 9) state.stiffness = read_stiffness(in);
    check_size(in, state);
    if (in.has("h")) {
      state.spacing = in.optional("h");
      if (state.spacing <= 0)
        in.fail(fmt::format("column h: {} is not a spacing, expected a positive number", state.spacing));
    }
    if (in.has("energy")) state.energy = in.optional("energy");
    if (jets) state.jet = read_jet(in);
    states.push_back(std::move(state));
  }
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
  std::vector<Vec3> points;
  while (in.next()) points.push_back(in.vector("x", "y", "z"));
  if (points.empty()) throw InputError({.file = in.name()}, "holds no points, expected rows x,y,z");
  return points;
}

std::vector<SitedPoint> read_sited_points_csv(const std::filesystem::path& file) {
  constexpr std::array<const char*, 6> required{"sx", "sy", "sz", "x", "y", "z"};
  NamedRows in(file, required, true);
  std::vector<SitedPoint> points;
  while (in.next()) points.push_back({in.vector("sx", "sy", "sz"), in.vector("x", "y", "z")});
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
