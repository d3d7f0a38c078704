#pragma once
// Guards against a state file that is made to mislead or to hang its reader. Private to this room. Views,
// triggers, virtual tables and expressions in the place of the plain tables are refused, and no query may take
// more steps than the size of the file explains: pages that name each other hold endless rows.

#include <cstdint>
#include <string>

#include "geometry/states/sqlite_handle.hpp"

namespace forefeel {

// While it lives, a query of this database ends with an InputError after 10^7 steps of SQLite's machine and 50
// more for each byte of the file.
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

// InputError unless identity, header, notes and states are plain tables with an end.
void check_plain_tables(sqlite3* database, const std::string& where);

}  // namespace forefeel
