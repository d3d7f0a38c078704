#include "geometry/states/sqlite_handle.hpp"

#include <fmt/format.h>

#include <utility>

namespace forefeel::sqlite {

[[noreturn]] void fail_database(sqlite3* database, const std::string& where) {
  const int code = sqlite3_errcode(database) & 0xff;
  const char* meaning =
      code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? "is damaged or no state file"
      : code == SQLITE_BUSY || code == SQLITE_LOCKED  ? "is in use by another process"
      : code == SQLITE_FULL                           ? "cannot be written, the disk is full"
      : code == SQLITE_READONLY                       ? "cannot be written, it is read-only"
      : code == SQLITE_IOERR                          ? "cannot be read or written"
      : code == SQLITE_TOOBIG                         ? "has a text of more than 2 MB, expected a few lines"
      : code == SQLITE_INTERRUPT
          ? "takes more steps to read than its size explains, expected a state file with an end"
          : "is not a usable state file";
  throw InputError({.file = where}, fmt::format("{} ({})", meaning, sqlite3_errmsg(database)));
}

Database open_database(const std::string& name, const std::string& where, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  Database database(raw);
  if (!database) throw InputError({.file = where}, "cannot be opened, no memory");
  if (code != SQLITE_OK) fail_database(database.get(), where);
  sqlite3_busy_timeout(database.get(), 5000);
  // The file may be untrusted: nothing in its schema may be executed.
  for (const auto& [option, on] :
       {std::pair(SQLITE_DBCONFIG_DEFENSIVE, 1), std::pair(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0),
        std::pair(SQLITE_DBCONFIG_ENABLE_VIEW, 0), std::pair(SQLITE_DBCONFIG_ENABLE_TRIGGER, 0)})
    sqlite3_db_config(database.get(), option, on, nullptr);
  sqlite3_exec(database.get(), "PRAGMA cell_size_check = 1", nullptr, nullptr, nullptr);
  return database;
}

void execute(sqlite3* database, const std::string& where, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail_database(database, where);
}

}  // namespace forefeel::sqlite
