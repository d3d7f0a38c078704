#include "geometry/states/state_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "geometry/common/error.hpp"
#include "geometry/states/jet_columns.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {

using sqlite::execute;
using sqlite::Statement;

namespace {

constexpr int application_id = 0x46465331;  // "FFS1"
constexpr int schema_version = 1;

constexpr const char* schema = R"sql(
CREATE TABLE identity (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE header (key TEXT PRIMARY KEY, value REAL);
CREATE TABLE notes (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE states (
  id INTEGER PRIMARY KEY,
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  fx REAL, fy REAL, fz REAL,
  k11 REAL, k12 REAL, k13 REAL, k21 REAL, k22 REAL, k23 REAL, k31 REAL, k32 REAL, k33 REAL,
  energy REAL, h REAL, status TEXT NOT NULL, multivalued INTEGER NOT NULL,
  iterations INTEGER NOT NULL, residual REAL, seconds REAL, min_jacobian REAL,
  parent_x REAL, parent_y REAL, parent_z REAL, displacements BLOB, checksum INTEGER);
)sql";

constexpr const char* columns =
    "x, y, z, fx, fy, fz, k11, k12, k13, k21, k22, k23, k31, k32, k33, energy, h, status, multivalued, "
    "iterations, "
    "residual, seconds, min_jacobian, parent_x, parent_y, parent_z, displacements";
constexpr const char* insert_values = "?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?";
constexpr int next_column = 29;  // of a query: behind these, checksum and id; those of sites, those of jets
constexpr std::array<const char*, 3> site_columns{"sx", "sy", "sz"};
constexpr std::array<const char*, 6> box_keys{"box_low_x",  "box_low_y",  "box_low_z",
                                              "box_high_x", "box_high_y", "box_high_z"};

std::string quoted_jet_columns() {  // limit is a word of SQL
  return fmt::format("\"{}\"", fmt::join(jet_columns(), "\", \""));
}

Vec3 read_site(Statement& row, const std::string& where) {
  const Vec3 site(row.real(next_column), row.real(next_column + 1), row.real(next_column + 2));
  if (site.array().isNaN().all()) return site;
  if (!site.allFinite() || site.cwiseAbs().maxCoeff() > largest_number)
    throw InputError({.file = where}, "a state's site is not a place");
  return site;
}

std::shared_ptr<const EnergyJet> read_jet(Statement& row, int i, const std::string& where) {
  JetCells cells;
  for (double& e : cells.coefficients) e = row.real(i++);
  cells.limit = row.real(i);
  JetOfCells read = jet_of(cells);
  if (!read.problem.empty()) throw InputError({.file = where}, read.problem);
  return std::move(read.jet);
}

State read_row(Statement& row, const std::string& where) {
  State state;
  int i = 0;
  for (int k = 0; k < 3; ++k) state.at[k] = row.real(i++);
  for (int k = 0; k < 3; ++k) state.force[k] = row.real(i++);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) state.stiffness(r, c) = row.real(i++);
  state.energy = row.real(i++);
  state.spacing = row.real(i++);
  const std::optional<SolveStatus> status = solve_status(row.text(i++));
  if (!status)
    throw InputError({.file = where},
                     fmt::format("a state has the unknown status '{:.20}'", row.text(i - 1)));
  state.solve.status = *status;
  state.solve.multivalued = row.integer(i++) != 0;
  state.solve.iterations = static_cast<int>(row.integer(i++));
  state.solve.residual = row.real(i++);
  state.solve.seconds = row.real(i++);
  state.solve.min_jacobian = row.real(i++);
  for (int k = 0; k < 3; ++k) state.solve.parent[k] = row.real(i++);
  // With a force it is an equilibrium (state_outcome.hpp), without one the solve failed there.
  if (state.solve.status == SolveStatus::inverted && state.force.allFinite() && state.solve.min_jacobian <= 0)
    state.solve.status = SolveStatus::converged;
  if (const std::string_view bytes = row.bytes(i); !bytes.empty()) {
    if (bytes.size() % (3 * sizeof(double)) != 0)
      throw InputError({.file = where}, "a state's displacements are cut short");
    std::vector<double> displacements(bytes.size() / sizeof(double));
    std::memcpy(displacements.data(), bytes.data(), bytes.size());
    state.displacements = std::make_shared<const std::vector<double>>(std::move(displacements));
  }
  // Of a place without a force, all three are NULL.
  const bool place_alone = state.solve.status == SolveStatus::measured && state.force.array().isNaN().all();
  if (!state.at.allFinite() || (state.usable() && !state.force.allFinite() && !place_alone))
    throw InputError({.file = where}, "a state has a position or force that is not finite");
  const auto too_large = [](const auto& values) { return (values.array().abs() > largest_number).any(); };
  if (too_large(state.at) || too_large(state.force) || too_large(state.stiffness))
    throw InputError({.file = where},
                     fmt::format("a position, force or stiffness is above {:g} in size, expected SI units",
                                 largest_number));
  if (state.spacing <= 0)
    throw InputError(
        {.file = where},
        fmt::format("a state has the spacing h = {}, expected a positive number", state.spacing));
  return state;
}

// Checksum of all values of a row as they are read back: every NaN is one value, and so are 0 and -0. Each
// step is a bijection of the sum so far, so a change of any single value changes the result.
std::int64_t checksum_of(const State& state, std::string_view status) {
  std::uint64_t sum = 0x46465331;
  const auto take = [&](std::uint64_t word) {
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
    sum ^= sum >> 32;
  };
  const auto number = [&](double value) {
    take(std::isnan(value) ? 0x7ff8000000000000u : value == 0 ? 0 : std::bit_cast<std::uint64_t>(value));
  };
  for (int k = 0; k < 3; ++k) number(state.at[k]);
  for (int k = 0; k < 3; ++k) number(state.force[k]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) number(state.stiffness(r, c));
  for (const double value :
       {state.energy, state.spacing, state.solve.residual, state.solve.seconds, state.solve.min_jacobian})
    number(value);
  for (int k = 0; k < 3; ++k) number(state.solve.parent[k]);
  for (const char letter : status) take(static_cast<unsigned char>(letter));
  take(state.solve.multivalued ? 2 : 1);
  take(static_cast<std::uint64_t>(state.solve.iterations));
  if (state.displacements && !state.displacements->empty()) {
    take(state.displacements->size());
    for (const double value : *state.displacements) take(std::bit_cast<std::uint64_t>(value));
  }
  if (state.jet) {
    const std::size_t terms = jet_terms_of_order(state.jet->order);
    take(terms);
    for (std::size_t i = 0; i < terms; ++i) number(state.jet->coefficients[i]);
    number(state.jet->limit);
  }
  if (state.has_site())
    for (int k = 0; k < 3; ++k) number(state.site[k]);
  return static_cast<std::int64_t>(sum);
}

// Which columns a table has beside those of every file.
struct Extra {
  bool sites = false, jets = false;
};

void bind_row(Statement& insert, const State& state, Extra extra) {
  int i = 1;
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.at[k]);
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.force[k]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) insert.bind(i++, state.stiffness(r, c));
  insert.bind(i++, state.energy);
  insert.bind(i++, state.spacing);
  insert.bind(i++, name(outcome(state)));
  insert.bind(i++, state.solve.multivalued ? 1 : 0);
  insert.bind(i++, state.solve.iterations);
  insert.bind(i++, state.solve.residual);
  insert.bind(i++, state.solve.seconds);
  insert.bind(i++, state.solve.min_jacobian);
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.solve.parent[k]);
  if (state.displacements)
    insert.bind_bytes(i, state.displacements->data(), state.displacements->size() * sizeof(double));
  else
    insert.bind_null(i);
  insert.bind(++i, checksum_of(state, name(outcome(state))));
  for (int k = 0; k < 3 && extra.sites; ++k) insert.bind(++i, state.site[k]);
  if (!extra.jets) return;
  const JetCells cells = cells_of(state.jet.get());
  for (const double e : cells.coefficients) insert.bind(++i, e);
  insert.bind(++i, cells.limit);
}

}  // namespace

void create_tables(sqlite3* database, const std::string& where, const StateFileHeader& header) {
  execute(database, where,
          fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}; BEGIN", application_id,
                      schema_version)
              .c_str());
  execute(database, where, schema);
  write_header(database, where, header);
  execute(database, where, "COMMIT");
}

void check_schema(sqlite3* database, const std::string& where) {
  Statement id(database, where, "PRAGMA application_id");
  if (!id.step() || id.integer(0) != application_id)
    throw InputError({.file = where}, "is a database, but not a state file");
  Statement version(database, where, "PRAGMA user_version");
  if (!version.step() || version.integer(0) != schema_version)
    throw InputError({.file = where},
                     fmt::format("has schema version {}, expected {}", version.integer(0), schema_version));
  check_plain_tables(database, where);
  Statement probe(database, where, fmt::format("SELECT {} FROM states LIMIT 0", columns).c_str());
  probe.step();
}

namespace {

void check_header(const StateFileHeader& header, const std::string& where) {
  if (header.spacing <= 0 || header.spacing > largest_number)
    throw InputError({.file = where, .key = "header"},
                     fmt::format("spacing is {}, expected a number above 0 [m]", header.spacing));
  for (int axis = 0; axis < 3; ++axis) {
    const double low = header.box.low[axis], high = header.box.high[axis];
    if (low > high || std::abs(low) > largest_number || std::abs(high) > largest_number)
      throw InputError({.file = where, .key = "header"},
                       fmt::format("box reaches from {} to {} along {}, expected a finite box [m]", low, high,
                                   "xyz"[axis]));
  }
}

}  // namespace

StateFileHeader read_header(sqlite3* database, const std::string& where) {
  const StepLimit limit(database);
  TextLimit text(database, where);
  StateFileHeader header;
  for (auto [table, target] : {std::pair("identity", &header.identity), std::pair("notes", &header.notes)}) {
    Statement rows(database, where, fmt::format("SELECT key, value FROM {}", table).c_str());
    while (rows.step()) {
      text.count(rows.text(0).size() + rows.text(1).size());
      (*target)[std::string(rows.text(0))] = std::string(rows.text(1));
    }
  }
  Statement numbers(database, where, "SELECT key, value FROM header");
  while (numbers.step()) {
    if (numbers.text(0) == "spacing") header.spacing = numbers.real(1);
    for (Eigen::Index i = 0; i < 6; ++i)
      if (numbers.text(0) == box_keys[static_cast<std::size_t>(i)])
        (i < 3 ? header.box.low[i] : header.box.high[i - 3]) = numbers.real(1);
  }
  check_header(header, where);
  return header;
}

void write_header(sqlite3* database, const std::string& where, const StateFileHeader& header) {
  for (auto [table, source] : {std::pair("identity", &header.identity), std::pair("notes", &header.notes)}) {
    Statement insert(database, where, fmt::format("INSERT INTO {} VALUES (?, ?)", table).c_str());
    for (const auto& [key, value] : *source) {
      insert.bind(1, std::string_view(key)), insert.bind(2, std::string_view(value));
      insert.step(), insert.reset();
    }
  }
  Statement insert(database, where, "INSERT INTO header VALUES (?, ?)");
  const auto put = [&](std::string_view key, double value) {
    insert.bind(1, key), insert.bind(2, value);
    insert.step(), insert.reset();
  };
  put("spacing", header.spacing);
  for (Eigen::Index i = 0; i < 6; ++i)
    put(box_keys[static_cast<std::size_t>(i)], i < 3 ? header.box.low[i] : header.box.high[i - 3]);
}

bool has_checksums(sqlite3* database, const std::string& where) {
  Statement columns_of(database, where, "SELECT 1 FROM pragma_table_info('states') WHERE name = 'checksum'");
  return columns_of.step();
}

namespace {

bool has_jets(sqlite3* database, const std::string& where) {
  Statement rows(database, where, "SELECT name FROM pragma_table_info('states')");
  std::size_t found = 0;
  while (rows.step()) found += std::ranges::count(jet_columns(), rows.text(0)) > 0 ? 1 : 0;
  if (found != 0 && found != jet_columns().size())
    throw InputError({.file = where}, fmt::format("has {} of the {} columns of jets, expected all or none",
                                                  found, jet_columns().size()));
  return found != 0;
}

bool has_sites(sqlite3* database, const std::string& where) {
  Statement rows(database, where,
                 "SELECT count(*) FROM pragma_table_info('states') WHERE name IN ('sx', 'sy', 'sz')");
  rows.step();
  const std::int64_t found = rows.integer(0);
  if (found != 0 && found != 3)
    throw InputError({.file = where},
                     fmt::format("has {} of the 3 columns of sites, expected all or none", found));
  return found != 0;
}

std::string names_of_columns(Extra extra) {
  std::string names;
  if (extra.sites) names += fmt::format(", {}", fmt::join(site_columns, ", "));
  if (extra.jets) names += ", " + quoted_jet_columns();
  return names;
}

}  // namespace

void insert_states(sqlite3* database, const std::string& where, std::span<const State> states) {
  const Extra extra{std::ranges::any_of(states, &State::has_site),
                    std::ranges::any_of(states, [](const State& s) { return s.jet != nullptr; })};
  const auto add = [&](const auto& names) {
    for (const auto& column : names)
      execute(database, where, fmt::format("ALTER TABLE states ADD COLUMN \"{}\" REAL", column).c_str());
  };
  if (extra.jets && !has_jets(database, where)) add(jet_columns());
  if (extra.sites && !has_sites(database, where)) add(site_columns);
  const std::string names = std::string(columns) + ", checksum" + names_of_columns(extra);
  std::string values = insert_values;
  for (std::size_t i = 0; i < (extra.sites ? 3 : 0) + (extra.jets ? jet_columns().size() : 0); ++i)
    values += ",?";
  Statement insert(database, where,
                   fmt::format("INSERT INTO states ({}) VALUES ({})", names, values).c_str());
  for (const State& state : states) {
    bind_row(insert, state, extra);
    insert.step(), insert.reset();
  }
}

namespace {
constexpr int status_column = 17, checksum_column = 27, id_column = 28;
}

StateRows::StateRows(sqlite3* database, const std::string& where, bool checksums)
    : where_(where),
      limit_(database),
      sites_(has_sites(database, where)),
      jets_(has_jets(database, where)),
      rows_(database, where,
            fmt::format("SELECT {}, {}, id{} FROM states ORDER BY id", columns,
                        checksums ? "checksum" : "NULL", names_of_columns({sites_, jets_}))
                .c_str()) {}

bool StateRows::next() {
  return rows_.step();
}

std::optional<State> StateRows::read() {
  const auto whole_row = [&] {
    State state = read_row(rows_, where_);
    if (sites_) state.site = read_site(rows_, where_);
    if (jets_) state.jet = read_jet(rows_, next_column + (sites_ ? 3 : 0), where_);
    return state;
  };
  if (rows_.is_null(checksum_column)) return whole_row();  // of an older file
  std::optional<State> state;
  try {
    state = whole_row();
  } catch (const InputError&) {  // too damaged to be a state
  }
  // Older files write converged even if det F <= 0, so the checksum uses the word in the file.
  if (state && checksum_of(*state, rows_.text(status_column)) != rows_.integer(checksum_column))
    state.reset();
  return state;
}

std::int64_t StateRows::id() {
  return rows_.integer(id_column);
}

}  // namespace forefeel
