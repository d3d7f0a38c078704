#include "geometry/states/hostile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

using sqlite::Statement;

constexpr std::int64_t free_steps = 10'000'000, steps_per_byte = 50;
constexpr int longest_text = 2'000'000;            // [bytes]
constexpr std::size_t longest_texts = 16'000'000;  // together
constexpr int counted_at_once = 10'000;
constexpr std::array<const char*, 4> tables{"identity", "header", "notes", "states"};

std::int64_t bytes_of(sqlite3* database) {
  sqlite3_file* file = nullptr;
  sqlite3_int64 bytes = 0;
  if (sqlite3_file_control(database, "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK || !file)
    return 0;
  if (!file->pMethods || file->pMethods->xFileSize(file, &bytes) != SQLITE_OK) return 0;
  sqlite3_file* log = nullptr;  // what is committed, but not yet in the file
  sqlite3_int64 more = 0;
  if (sqlite3_file_control(database, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log) != SQLITE_OK || !log)
    return bytes;
  if (log->pMethods && log->pMethods->xFileSize(log, &more) == SQLITE_OK) bytes += more;
  return bytes;
}

bool mentions(const std::string& sql, const char* word) {
  return sql.find(word) != std::string::npos;
}

[[noreturn]] void refuse(const std::string& where, std::string_view name, const char* what) {
  throw InputError({.file = where}, fmt::format("'{:.40}' is {}, expected a plain table", name, what));
}

// InputError unless it is a table that only stores values and computes nothing.
void check_table(Statement& row, const std::string& where) {
  const std::string_view name = row.text(1);
  if (row.text(0) != "table") refuse(where, name, "no table");
  const std::string sql = lower_case(row.text(3));
  if (row.integer(2) <= 0) refuse(where, name, "a virtual table");
  for (const char* word : {"check(", "check (", "generated", " as ", " as("})
    if (mentions(sql, word)) refuse(where, name, "a table with expressions");
}

}  // namespace

StepLimit::StepLimit(sqlite3* database)
    : database_(database),
      left_(free_steps / counted_at_once + steps_per_byte * bytes_of(database) / counted_at_once) {
  sqlite3_progress_handler(database, counted_at_once, &StepLimit::count, this);
}

StepLimit::~StepLimit() {
  sqlite3_progress_handler(database_, 0, nullptr, nullptr);
}

int StepLimit::count(void* self) {
  return --static_cast<StepLimit*>(self)->left_ < 0 ? 1 : 0;
}

TextLimit::TextLimit(sqlite3* database, const std::string& where)
    : database_(database),
      where_(where),
      left_(longest_texts),
      before_(sqlite3_limit(database, SQLITE_LIMIT_LENGTH, longest_text)) {}

TextLimit::~TextLimit() {
  sqlite3_limit(database_, SQLITE_LIMIT_LENGTH, before_);
}

void TextLimit::count(std::size_t bytes) {
  if (bytes > left_)
    throw InputError({.file = where_},
                     fmt::format("has more than {} MB of text in identity and notes, expected a few lines",
                                 longest_texts / 1'000'000));
  left_ -= bytes;
}

void check_plain_tables(sqlite3* database, const std::string& where) {
  const StepLimit limit(database);
  std::size_t found = 0;
  Statement rows(database, where, "SELECT type, name, rootpage, sql, tbl_name FROM sqlite_master");
  while (rows.step()) {
    const auto is_ours = [](std::string_view name) {
      return std::ranges::any_of(tables, [&](const char* table) { return lower_case(name) == table; });
    };
    if (is_ours(rows.text(1))) {
      check_table(rows, where);
      ++found;
    } else if (is_ours(rows.text(4)) && rows.text(0) == "trigger") {
      refuse(where, rows.text(4), "a table with triggers");
    } else if (is_ours(rows.text(4)) && std::ranges::count(rows.text(3), '(') > 1) {
      refuse(where, rows.text(4), "a table with an index of expressions");
    }
  }
  if (found != tables.size())
    throw InputError(
        {.file = where},
        fmt::format("holds {} of the {} tables identity, header, notes and states", found, tables.size()));
  for (const char* table : tables)  // counts row by row; count(*) could not be stopped
    Statement(database, where, fmt::format("SELECT sum(1) FROM {}", table).c_str()).step();
}

}  // namespace forefeel
