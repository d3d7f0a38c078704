#pragma once
// Guards against a state file that was crafted to mislead or hang its reader. Private to this room. Views,
// triggers, virtual tables and expressions instead of plain tables are refused. No query may take more steps than
// the size of the file explains, because pages that refer to each other in a cycle yield endless rows.

#include <cstddef>
#include <cstdint>
#include <string>

#include "geometry/states/sqlite_handle.hpp"

namespace forefeel {

// While this object exists, a query of the database ends with an InputError after 10^7 steps of SQLite's virtual
// machine plus 50 for each byte of the file.
class StepLimit {
 public:
  explicit StepLimit(sqlite3* database);
  ~StepLimit();
  StepLimit(const StepLimit&) = delete;
  StepLimit& operator=(const StepLimit&) = delete;

 private:
  static int count(void* self);

  sqlite3* database_;
  std::int64_t left_;
};

// While this object exists, a query ends with an InputError at a text of more than 2 MB. The texts of identity and
// notes are a few lines; together they may have 16 MB.
class TextLimit {
 public:
  TextLimit(sqlite3* database, const std::string& where);
  ~TextLimit();
  TextLimit(const TextLimit&) = delete;
  TextLimit& operator=(const TextLimit&) = delete;
  void count(std::size_t bytes);  // of a text that was read; InputError where all texts together are too long

 private:
  sqlite3* database_;
  const std::string& where_;
  std::size_t left_;
  int before_;
};

// InputError unless identity, header, notes and states are plain, finite tables.
void check_plain_tables(sqlite3* database, const std::string& where);

}  // namespace forefeel
