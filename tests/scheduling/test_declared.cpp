// The columns that a run and a cell of a study write are those that `forefeel help outputs` lists.

#include "scheduling/record/run_files.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/study/cell_result.hpp"
#include "tests/scheduling/small_body.hpp"

namespace {

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// "error.by_label.gap.p50" -> "error.by_label.LABEL.p50"
std::string without_label(std::string name) {
  for (const Label label : all_labels) {
    const std::string word = "." + std::string(forefeel::name(label));
    const std::size_t at = name.find(word);
    const bool whole =
        at != std::string::npos && (at + word.size() == name.size() || name[at + word.size()] == '.');
    if (whole) name.replace(at, word.size(), ".LABEL");
  }
  return name;
}

std::set<std::string> names_in(const std::vector<Declared>& rows) {
  const std::vector<std::string> names = names_of(rows);
  return {names.begin(), names.end()};
}

}  // namespace

TEST_CASE("the tables of a virtual run have the columns that are declared for it, and as many cells a row") {
  const TemporaryFolder folder;
  const SessionInput input = small_input();
  const SessionOptions options = virtual_options(0.3);
  write_run_files(folder.path(), run_session(input, options), options);
  for (const DeclaredTable& table : declared_run_files()) {
    INFO(table.name);
    std::vector<Declared> columns = table.rows;
    std::erase_if(columns, [](const Declared& c) {
      return c.meaning.ends_with("real clock only") || c.meaning.ends_with("viscous bodies only") ||
             c.meaning.ends_with("contact.anywhere only");
    });
    const std::vector<std::string> lines = lines_of(folder / table.name);
    REQUIRE(lines.size() > 1);
    CHECK(lines.front() == header_of(columns));
    const auto commas = std::ranges::count(lines.front(), ',');
    CHECK(std::ranges::all_of(lines,
                              [&](const std::string& l) { return std::ranges::count(l, ',') == commas; }));
  }
}

TEST_CASE(
    "every column of a cell is declared, and every declared one but those of special studies is written") {
  const SessionInput input = small_input();
  const SessionOptions options = virtual_options(0.2);
  std::set<std::string> written{"motion_seconds"}, declared = names_in(cells_output().rows);
  StudyCellResult cell = cell_result(run_session(input, options), input, options);
  const std::unique_ptr<Predictor> predictor = make_predictor({"kalman"});
  add_prediction(PredictionScore(*predictor, options.clock.frame).report(), cell);
  for (const Column& column : cell.columns()) written.insert(without_label(column.name));
  std::erase_if(declared, [](const std::string& name) {
    return name.starts_with("sustained.") || name.starts_with("regret.");
  });
  CHECK(written == declared);
}
