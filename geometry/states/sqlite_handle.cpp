#include "geometry/states/sqlite_handle.hpp"

#include <fmt/format.h>

namespace forefeel::sqlite {

[[noreturn]] void fail_database(sqlite3* database, const std::string& where) {
  const int code = sqlite3_errcode(database) & 0xff;
  const char* meaning = code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? "is damaged or no state file"
                        : code == SQLITE_BUSY || code == SQLITE_LOCKED  ? "is in use by another process"
                        : code == SQLITE_FULL     ? "cannot be written, the disk is full"
                        : code == SQLITE_READONLY ? "cannot be written, it is read-only"
                        : code == SQLITE_IOERR    ? "cannot be read or written"
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
  return database;
}

void execute(sqlite3* database, const std::string& where, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail_database(database, where);
}

}  // namespace forefeel::sqlite
