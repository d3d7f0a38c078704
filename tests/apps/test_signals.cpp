// Signals and failing writes. A session that gets SIGHUP, whose disk is full or whose reader is gone keeps the results
// that it can save, and reports those that it cannot.

#include "tests/support/executable.hpp"

namespace {

// The cells of the last line of a table.
std::vector<std::string> last_row(const Workshop& shop, const std::string& file) {
  std::istringstream line(shop.shell("tail -n 1 " + file).out);
  std::vector<std::string> cells;
  for (std::string cell; std::getline(line, cell, ',');) cells.push_back(cell);
  return cells;
}

}  // namespace

TEST_CASE("SIGHUP and SIGTERM end a session with zero force and with all of its files", "[signals]") {
  const BeamShop shop;
  for (const std::string signal : {"HUP", "TERM"}) {
    CAPTURE(signal);
    const std::string run = "run" + signal;
    const Workshop::Outcome outcome = shop.shell(
        executable() + " session beam.toml --clock real --seconds 600 --device path:circle --json -o " + run +
        " & p=$!; " +
        wait_until("[ -s " + run + "/session.states-wal ] && " + is_larger(run + "/session.inputs")) +
        "kill -" + signal + " $p; wait $p");
    INFO(outcome.err);
    CHECK(outcome.code == 1);
    CHECK(outcome.json()["interrupted"] == true);
    CHECK(outcome.json()["failures"].empty());
    const std::vector<std::string> row = last_row(shop, run + "/frames.csv");
    REQUIRE(row.size() > 7);
    for (int i = 4; i < 7; ++i) CHECK(std::stod(row[static_cast<std::size_t>(i)]) == 0);
    for (const char* file : {"/summary.json", "/report.html", "/states.csv", "/dispatch.csv"})
      CHECK_FALSE(shop.read(run + file).empty());
  }
}

TEST_CASE("under nohup a session does not end with its terminal", "[signals]") {
  const BeamShop shop;
  const Workshop::Outcome outcome = shop.shell(
      "trap '' HUP; " + executable() + " session beam.toml --clock real --seconds 3 --json -o run & p=$!; " +
      wait_until("[ -s run/session.states-wal ]") + "kill -HUP $p; wait $p");
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  CHECK(outcome.json()["interrupted"] == false);
}

TEST_CASE("files that may not grow cost a session those that do not fit, and nothing else", "[signals]") {
  const BeamShop shop;
  const std::string session = " session beam.toml --clock virtual --json --seconds ";
  REQUIRE(shop.shell(executable() + session + "0.1 -o warm").code == 0);  // the cache
  const Workshop::Outcome outcome = shop.shell("ulimit -f 128; " + executable() + session + "1 -o run");
  INFO(outcome.err);
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["frames"] == 1000);
  CHECK(outcome.json()["interrupted"] == false);
  CHECK_THAT(outcome.json()["failures"].dump(), Contains("frames.csv: cannot be written"));
  CHECK_THAT(outcome.err, Contains("frames.csv: cannot be written: File too large"));
  CHECK(!shop.has("run/frames.csv"));
  for (const char* file : {"summary.json", "states.csv", "dispatch.csv", "switches.csv"})
    CHECK_FALSE(shop.read(std::string("run/") + file).empty());
  CHECK_THAT(shop.files(), !Contains(".part"));
}

TEST_CASE("a reader that is gone does not end a session, whose files are kept", "[signals]") {
  const BeamShop shop;
  shop.shell(
      "{ " + executable() +
      " session beam.toml --clock virtual --seconds 0.1 --json --quiet -o run; echo $? > code; } | true");
  const std::string code = shop.read("code");
  CHECK((code == "0\n" || code == "1\n"));  // no signal
  for (const char* file : {"summary.json", "report.html", "frames.csv"})
    CHECK_FALSE(shop.read(std::string("run/") + file).empty());
}
