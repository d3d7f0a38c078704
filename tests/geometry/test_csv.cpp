// The rows of a CSV file, and the readers of columns of numbers and of text that use them.

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/test.hpp"

TEST_CASE("Rows are cut at commas; blank lines, comments and a byte order mark are skipped", "[csv]") {
  const std::string content = "\xef\xbb\xbf# note\r\n\n a , \"b c\",\r\n1,\t2 ,3";
  CsvRows rows(content, "x.csv");
  REQUIRE(rows.next());
  CHECK(rows.line() == 3);
  REQUIRE(rows.cells().size() == 3);
  CHECK(rows.cells()[0] == "a");
  CHECK(rows.cells()[1] == "b c");
  CHECK(rows.cells()[2].empty());
  rows.again();
  REQUIRE(rows.next());
  CHECK(rows.line() == 3);
  REQUIRE(rows.next());
  CHECK(rows.cells()[1] == "2");
  CHECK(rows.where() == InputPlace{.file = "x.csv", .line = 4});
  CHECK_FALSE(rows.next());
}

TEST_CASE("A cell in quotes may hold commas, doubled quotes and line breaks", "[csv]") {
  const std::string content = "x,note,y\r\n1,\"a\r\n\r\n# b, \"\"c\"\"\n\",2\n3,5\" long,4\n5,\"open,6\n";
  CsvRows rows(content, "x.csv");
  REQUIRE((rows.next() && rows.next()));
  CHECK(rows.line() == 2);
  REQUIRE(rows.cells().size() == 3);
  CHECK(rows.cells()[1] == "a\r\n\r\n# b, \"\"c\"\"\n");
  CHECK(rows.cells()[2] == "2");
  REQUIRE(rows.next());
  CHECK(rows.line() == 6);
  CHECK(rows.cells()[1] == "5\" long");
  REQUIRE(rows.next());
  CHECK(rows.cells().size() == 3);
  CHECK_FALSE(rows.next());
}

TEST_CASE("Columns of numbers are found by name or, without a header, by position", "[csv]") {
  const TemporaryFolder folder;
  constexpr std::string_view columns[] = {"t", "x"};
  const CsvTable named = read_csv(folder.write("a.csv", "x,note,t\n1,one,0.5\n\n+2,,1e-3\n"), columns);
  REQUIRE(named.rows() == 2);
  CHECK(named.at(0, 0) == 0.5);
  CHECK(named.at(0, 1) == 1);
  CHECK(named.at(1, 0) == 1e-3);
  CHECK(named.at(1, 1) == 2);
  CHECK(named.lines == std::vector<std::size_t>{2, 4});
  const CsvTable plain = read_csv(folder.write("b.csv", "0,1,9\n2,3\n"), columns);
  CHECK(plain.values == std::vector<double>{0, 1, 2, 3});
}

TEST_CASE("What is wrong with columns of numbers is said with file and line", "[csv]") {
  const TemporaryFolder folder;
  constexpr std::string_view columns[] = {"t", "x"};
  const auto said = [&](std::string_view content) {
    const auto file = folder.write("a.csv", content);
    const std::string text = error_of([&] { read_csv(file, columns); });
    return text.starts_with(file.string()) ? text.substr(file.string().size()) : text;
  };
  CHECK(said("") == ": holds no rows, expected t,x");
  CHECK(said("t,x\n") == ": holds no rows, expected t,x");
  CHECK(said("t,y\n1,2\n") == ":1: column x is missing, expected a header t,x");
  CHECK(said("t,x\n1,2\n1\n") == ":3: a row of 1 values, expected t,x");
  CHECK(said("t,x\n1,two\n") == ":2: x is 'two', expected a finite number");
  CHECK(said("t,x\n1,nan\n") == ":2: x is 'nan', expected a finite number");
  CHECK(error_of([&] { read_csv(folder / "none.csv", columns); }) ==
        (folder / "none.csv").string() + ": cannot be read, expected a CSV file");
}

TEST_CASE("Columns of text are read by name, and numbers where a cell is one", "[csv]") {
  const TemporaryFolder folder;
  const auto read = [&](std::string_view content) {
    return CsvText::read(folder.write("a.csv", content), "a file of a run");
  };
  const CsvText table = read("t,label,e\r\n0,safe,\n1,gap,0.5\n");
  CHECK(table.rows() == 2);
  CHECK(table.line(1) == 3);
  CHECK(table.text(1, "label") == "gap");
  CHECK(table.number(1, "e") == 0.5);
  CHECK(std::isnan(table.number(0, "e")));
  CHECK(std::isnan(table.number(0, "absent")));
  CHECK_FALSE(table.has("absent"));
  const std::string file = (folder / "a.csv").string();
  CHECK(error_of([&] { read("a,b\n1\n"); }) == file + ":2: has 1 cells, expected 2");
  CHECK(error_of([&] { read(""); }) == file + ": is empty, expected a header line");
  CHECK(error_of([&] { CsvText::read(folder / "none", "a file of a run"); }) ==
        (folder / "none").string() + ": cannot be read, expected a file of a run");
}

TEST_CASE("A row that was cut is refused: no missing digit is read as a zero", "[csv]") {
  const TemporaryFolder folder;
  constexpr std::string_view columns[] = {"t", "x"};
  const auto said = [&](std::string_view content, bool whole) {
    const auto file = folder.write("a.csv", content);
    const std::string text = error_of([&] { read_csv(file, columns, whole); });
    return text.starts_with(file.string()) ? text.substr(file.string().size()) : text;
  };
  CHECK(said("t,x,y,z\n0,1,2,3\n1,2\n", false) ==
        ":3: a row of 2 values, expected 4 as in the header: was the file cut short?");
  CHECK(said("t,x\n0,0.1\n1,0", true) ==
        ":3: the file ends within this line, expected a whole file: it was cut short");
  CHECK(said("t,x\n0,0.1\n1,0", false).empty());  // tables of others may end like this
  CHECK(said("t,x\n0,0.1\n1,0\n", true).empty());
  CHECK_THAT(error_of([&] { CsvText::read(folder.write("b.csv", "a,b\n1,2\n3,4"), "a file of a run"); }),
             Contains("b.csv:3: the file ends within this line"));
}

TEST_CASE("A line without an end is refused before it fills the memory", "[csv]") {
  constexpr std::string_view columns[] = {"t", "x"};
  CHECK(error_of([&] { read_csv("/dev/zero", columns); }) ==
        "/dev/zero:1: a line of more than 1048576 bytes, expected a text");
  const TemporaryFolder folder;
  const auto file = folder.write("a.csv", "t,x\n1,2\n" + std::string(2'000'000, '7') + "\n");
  CHECK_THAT(error_of([&] { read_csv(file, columns); }), Contains("a.csv:3: a line of more than"));
  CHECK_THAT(error_of([&] { read_points_csv(file); }), Contains("a.csv:3: a line of more than"));
}

TEST_CASE("A file that is larger than the memory is refused before it is read", "[csv]") {
  const TemporaryFolder folder;
  const auto file = folder.write("large.obj", "v 0 0 0\n");
  std::error_code error;
  fs::resize_file(file, std::uintmax_t{4} << 40, error);  // sparse
  if (error) return skip("this file system has no files of 4 TB");
  CHECK_THAT(error_of([&] { read_file(file); }), Contains("of memory are left, expected a smaller file"));
}
