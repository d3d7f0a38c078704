// State files that are made to hang or to mislead a reader.

#include <sqlite3.h>

#include "geometry/states/state_file.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

namespace {

void run_sql(const fs::path& file, const char* sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  const int code = sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
  INFO(sql << ": " << sqlite3_errmsg(database));
  CHECK(code == SQLITE_OK);
  sqlite3_close(database);
}

// A file of n states that SQL has changed.
fs::path changed(const TemporaryFolder& folder, const char* sql, int n = 4) {
  const auto file = folder / "s.states";
  fs::remove(file);
  { StateFile::open_or_create(file, header()).append(states(n)); }
  run_sql(file, sql);
  return file;
}

void check_refused_by_all(const fs::path& file, const char* text) {
  INFO(file);
  const std::string read = error_of([&] { StateFile::open_read_only(file).read_all(); });
  CHECK_THAT(read, Contains(text));
  CHECK_THAT(read, !Contains("\n"));
  CHECK_THAT(error_of([&] { load_states(file); }), Contains(text));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(file, header()); }), Contains(text));
}

}  // namespace

TEST_CASE("views without an end in the place of the tables are refused") {
  const TemporaryFolder folder;
  check_refused_by_all(changed(folder,
                               "ALTER TABLE states RENAME TO old; CREATE VIEW states AS WITH RECURSIVE n(i) "
                               "AS (SELECT 1 UNION ALL "
                               "SELECT i + 1 FROM n) SELECT i AS id, old.* FROM n, old;"),
                       "'states' is no table");
  check_refused_by_all(
      changed(folder,
              "DROP TABLE header; CREATE VIEW header AS WITH RECURSIVE n(i) AS (SELECT 1 UNION "
              "ALL SELECT i + 1 FROM n) SELECT 'spacing' AS key, 0.1 AS value FROM n;"),
      "'header' is no table");
}

TEST_CASE("tables that compute, triggers and missing tables are refused") {
  const TemporaryFolder folder;
  check_refused_by_all(
      changed(folder, "DROP TABLE notes; CREATE TABLE notes (key TEXT, value TEXT CHECK (value <> ''))"),
      "'notes' is a table with expressions");
  check_refused_by_all(
      changed(folder,
              "DROP TABLE notes; CREATE TABLE notes (key TEXT, value TEXT GENERATED ALWAYS AS (key || key))"),
      "'notes' is a table with expressions");
  check_refused_by_all(
      changed(folder,
              "CREATE TRIGGER more AFTER INSERT ON states BEGIN INSERT INTO notes VALUES (new.id, ''); END"),
      "'states' is a table with triggers");
  check_refused_by_all(changed(folder, "CREATE INDEX slow ON states (length(x))"), "an index of expressions");
  check_refused_by_all(changed(folder, "DROP TABLE header"), "holds 3 of the 4 tables");
  CHECK(StateFile::open_read_only(changed(folder, "CREATE INDEX plain ON states (x)")).size() == 4);
}

namespace {

// A number of big-endian bytes.
std::size_t number_at(const std::string& bytes, std::size_t at, std::size_t size) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

void put_number(std::string& bytes, std::size_t at, std::size_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (24 - 8 * i));
}

// All children of an interior page of a table: the cells' and the last one.
void set_children(std::string& page, std::size_t child) {
  for (std::size_t cell = 0; cell < number_at(page, 3, 2); ++cell)
    put_number(page, number_at(page, 12 + 2 * cell, 2), child);
  put_number(page, 8, child);
}

}  // namespace

TEST_CASE("pages that name each other hold endless rows, and the reader gives up") {
  const TemporaryFolder folder;
  const auto file = changed(folder, "PRAGMA journal_mode = DELETE; VACUUM", 400);
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    bytes = all.str();
  }
  const std::size_t size = number_at(bytes, 16, 2), pages = bytes.size() / size;
  std::size_t root = 0;  // the first interior page of a table: only the states fill more than one page
  for (std::size_t page = 2; page <= pages && root == 0; ++page)
    if (bytes[(page - 1) * size] == 5) root = page;
  REQUIRE(root != 0);
  const std::string page = bytes.substr((root - 1) * size, size);
  const std::size_t leaf = number_at(page, 8, 4);
  REQUIRE(number_at(page, 3, 2) > 10);  // children
  // 15 levels of pages; all children of a page are the page of the next level. This yields 10^15 rows and more.
  for (std::size_t level = 0; level < 15; ++level) {
    std::string more = page;
    set_children(more, level == 14 ? leaf : pages + level + 2);
    bytes += more;
  }
  std::string first = page;
  set_children(first, pages + 1);
  bytes.replace((root - 1) * size, size, first);
  put_number(bytes, 28, pages + 15);
  folder.write("endless.states", bytes);
  check_refused_by_all(folder / "endless.states", "takes more steps to read than its size explains");
}

TEST_CASE("a spacing of zero or less, and a box without a size, are refused") {
  const TemporaryFolder folder;
  for (const char* value : {"0", "-0.006", "1e300", "9e999"}) {
    const std::string sql = std::string("UPDATE header SET value = ") + value + " WHERE key = 'spacing'";
    check_refused_by_all(changed(folder, sql.c_str()), "header: spacing is");
  }
  check_refused_by_all(changed(folder, "UPDATE header SET value = 5 WHERE key = 'box_low_y'"),
                       "header: box reaches from 5 to 0.03 along y");
  check_refused_by_all(changed(folder, "UPDATE header SET value = -9e999 WHERE key = 'box_low_y'"),
                       "finite box");
  const auto old = changed(folder, "UPDATE states SET h = -1, checksum = NULL WHERE id = 1");
  CHECK_THAT(error_of([&] { load_states(old); }), Contains("spacing h = -1"));
}

TEST_CASE("texts of identity and notes that are too long are refused, one by one and together") {
  const TemporaryFolder folder;
  for (const char* sql : {"INSERT INTO identity VALUES ('mesh2', hex(zeroblob(1500000)))",
                          "INSERT INTO identity VALUES (hex(zeroblob(1500000)), 'a')",
                          "INSERT INTO notes VALUES ('a', hex(zeroblob(1500000)))"})
    check_refused_by_all(changed(folder, sql), "has a text of more than 2 MB");
  check_refused_by_all(changed(folder,
                               "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n LIMIT 20) "
                               "INSERT INTO notes SELECT i, hex(zeroblob(500000)) FROM n"),
                       "has more than 16 MB of text");
  const auto long_note = changed(folder, "INSERT INTO notes VALUES ('a', hex(zeroblob(500000)))");
  CHECK(StateFile::open_read_only(long_note).header().notes.at("a").size() == 1'000'000);
}
