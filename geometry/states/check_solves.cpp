#include "geometry/states/check_solves.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/states/sqlite_handle.hpp"

namespace forefeel {

namespace {

constexpr const char* checks_note = "checks";

std::string text_of(std::span<const State> checks) {
  std::string text;
  for (const State& s : checks)
    if (s.usable())
      text += fmt::format("{},{},{},{},{},{}\n", s.at.x(), s.at.y(), s.at.z(), s.force.x(), s.force.y(),
                          s.force.z());
  return text;
}

}  // namespace

void keep_checks(const std::filesystem::path& file, std::span<const State> checks) {
  const std::string where = file.string();
  const sqlite::Database database = sqlite::open_database(where, where, SQLITE_OPEN_READWRITE);
  sqlite::Statement insert(database.get(), where, "INSERT OR REPLACE INTO notes (key, value) VALUES (?, ?)");
  const std::string text = text_of(checks);
  insert.bind(1, std::string_view(checks_note));
  insert.bind(2, std::string_view(text));
  insert.step();
}

CheckSolves check_solves(const StateFileHeader& header) {
  CheckSolves checks{.states = {}, .box = header.box};
  const auto note = header.notes.find(checks_note);
  if (note == header.notes.end()) return checks;
  for (CsvRows rows(note->second, "notes"); rows.next();) {
    double value[6] = {};
    if (rows.cells().size() != 6) rows.fail("a check solve needs the six numbers x,y,z,fx,fy,fz");
    for (std::size_t i = 0; i < 6; ++i)
      if (!parse_real(rows.cells()[i], value[i]) || !(std::abs(value[i]) < 1e100))
        rows.fail(fmt::format("'{:.40}' in a check solve is not a finite number", rows.cells()[i]));
    State state;
    state.at = {value[0], value[1], value[2]};
    state.force = {value[3], value[4], value[5]};
    checks.states.push_back(state);
  }
  return checks;
}

}  // namespace forefeel
