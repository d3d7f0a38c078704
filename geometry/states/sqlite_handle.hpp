#pragma once
// Owners of a SQLite database and of a statement. Every failure is an InputError that names the file
// (`where`).

#include <sqlite3.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "geometry/common/error.hpp"

namespace forefeel::sqlite {

class Statement {
 public:
  Statement(sqlite3* database, const std::string& where, const char* sql)
      : database_(database), where_(where) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool step() {  // true: a row
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  void reset() { sqlite3_reset(statement_); }
  void bind(int i, double value) { sqlite3_bind_double(statement_, i, value); }  // NaN becomes NULL
  void bind(int i, std::int64_t value) { sqlite3_bind_int64(statement_, i, value); }
  void bind(int i, int value) { sqlite3_bind_int(statement_, i, value); }
  // The text or bytes must live until the next step().
  void bind(int i, std::string_view text) {
    sqlite3_bind_text(statement_, i, text.data(), static_cast<int>(text.size()), SQLITE_STATIC);
  }
  void bind_bytes(int i, const void* data, std::size_t size) {
    sqlite3_bind_blob64(statement_, i, data, size, SQLITE_STATIC);
  }
  void bind_null(int i) { sqlite3_bind_null(statement_, i); }

  bool is_null(int i) { return sqlite3_column_type(statement_, i) == SQLITE_NULL; }
  double real(int i) {
    return is_null(i) ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement_, i);
  }
  std::int64_t integer(int i) { return sqlite3_column_int64(statement_, i); }
  std::string_view text(int i) {
    const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_, i));
    return data ? std::string_view(data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, i)))
                : std::string_view();
  }
  std::string_view bytes(int i) {
    const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_, i));
    return data ? std::string_view(data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, i)))
                : std::string_view();
  }

 private:
  [[noreturn]] void fail();

  sqlite3* database_;
  const std::string& where_;
  sqlite3_stmt* statement_ = nullptr;
};

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

// flags: of sqlite3_open_v2; with SQLITE_OPEN_URI the name is a file: URI.
Database open_database(const std::string& name, const std::string& where, int flags);
void execute(sqlite3* database, const std::string& where, const char* sql);
[[noreturn]] void fail_database(sqlite3* database, const std::string& where);

inline void Statement::fail() {
  fail_database(database_, where_);
}

}  // namespace forefeel::sqlite
