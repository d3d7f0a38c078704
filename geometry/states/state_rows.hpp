#pragma once
// The tables of a state file (state_file.hpp describes them): schema, header and rows. Private to this room.
// `where` names the file in messages; every failure is an InputError.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "geometry/states/hostile_file.hpp"
#include "geometry/states/sqlite_handle.hpp"
#include "geometry/states/state_header.hpp"

namespace forefeel {

void create_tables(sqlite3* database, const std::string& where, const StateFileHeader& header);
void check_schema(sqlite3* database, const std::string& where);

StateFileHeader read_header(sqlite3* database, const std::string& where);
void write_header(sqlite3* database, const std::string& where, const StateFileHeader& header);

bool has_checksums(sqlite3* database, const std::string& where);  // older files lack the column
// Adds the columns of jets and of sites when the first state with one comes; call it within a transaction.
void insert_states(sqlite3* database, const std::string& where, std::span<const State> states);

// All rows, in order of insertion.
class StateRows {
 public:
  StateRows(sqlite3* database, const std::string& where, bool checksums);
  bool next();  // false after the last
  std::optional<State>
  read();  // none if the checksum is wrong; InputError for an invalid row without a checksum
  std::int64_t id();

 private:
  const std::string& where_;
  StepLimit limit_;
  bool sites_, jets_;  // whether the table has their columns
  sqlite::Statement rows_;
};

}  // namespace forefeel
