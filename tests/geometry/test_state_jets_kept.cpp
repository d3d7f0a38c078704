// Energy jets in state files, CSV files and messages: bit for bit, in any mixture of orders.

#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include "geometry/states/energy_jet.hpp"
#include "geometry/states/repeated_states.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_message.hpp"
#include "geometry/states/state_summary.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

namespace {

bool all_same(const std::vector<State>& a, const std::vector<State>& b) {
  return std::ranges::equal(a, b, [](const State& s, const State& t) { return same(s, t); });
}

void change(const fs::path& file, const std::string& sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  CHECK(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(database);
}

int columns_of_states(const fs::path& file) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  sqlite3_stmt* rows = nullptr;
  REQUIRE(sqlite3_prepare_v2(database, "SELECT * FROM states", -1, &rows, nullptr) == SQLITE_OK);
  const int columns = sqlite3_column_count(rows);
  sqlite3_finalize(rows);
  sqlite3_close(database);
  return columns;
}

}  // namespace

TEST_CASE("jets of all orders, and none, come back from a state file bit for bit") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  const std::vector<State> all = states_with_jets(40);
  StateFile::open_or_create(file, header()).append(all);
  CHECK(all_same(StateFile::open_read_only(file).read_all(), all));
  CHECK(load_states(file).damaged == 0);
  CHECK(summarise(all).with_jet == 30);
  StateFile again = StateFile::open_or_create(file, header());
  again.replace(header(), std::span(all).first(9));
  CHECK(all_same(again.read_all(), {all.begin(), all.begin() + 9}));
}

TEST_CASE("the columns of jets come with the first jet; files without one stay as they were") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  const std::vector<State> plain = states(20), jets = states_with_jets(20);
  {
    StateFile written = StateFile::open_or_create(file, header());
    const StateFile reader = StateFile::open_read_only(file);
    written.append(plain);
    CHECK(columns_of_states(file) == 29);
    CHECK(all_same(reader.read_all(), plain));
    written.append(std::span(jets).subspan(1, 1));
    CHECK(columns_of_states(file) == 29 + 47);
    written.append(std::span(plain).first(2));
    CHECK(reader.read_all().size() == 23);  // it was opened before the columns came
    CHECK(same(reader.read_all()[20], jets[1]));
  }
  StateFile again = StateFile::open_or_create(file, header());
  again.append(jets);
  const std::vector<State> read = again.read_all();
  CHECK(again.damaged() == 0);
  CHECK(all_same({read.begin() + 23, read.end()}, jets));
}

TEST_CASE("an older file without checksums takes jets too") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  const std::vector<State> plain = states(5), jets = states_with_jets(8);
  StateFile::open_or_create(file, header()).append(plain);
  change(file, "ALTER TABLE states DROP COLUMN checksum");
  CHECK(all_same(StateFile::open_read_only(file).read_all(), plain));
  StateFile::open_or_create(file, header()).append(jets);
  const std::vector<State> read = load_states(file).states;
  REQUIRE(read.size() == 13);
  CHECK(all_same({read.begin(), read.begin() + 5}, plain));
  CHECK(all_same({read.begin() + 5, read.end()}, jets));
}

TEST_CASE("a damaged jet damages its row") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  std::vector<State> all(6, state(1));
  for (int i = 0; i < 6; ++i) all[std::size_t(i)].jet = jet(3, 2 * i);
  StateFile::open_or_create(file, header()).append(all);
  change(file, "UPDATE states SET e300 = e300 * (1 + 2.3e-16) WHERE id = 1");
  change(file, "UPDATE states SET e004 = NULL WHERE id = 2");
  change(file, "UPDATE states SET \"limit\" = \"limit\" * 2 WHERE id = 3");
  change(file, "UPDATE states SET \"limit\" = NULL WHERE id = 4");
  change(file, "UPDATE states SET e500 = 1 WHERE id = 5");
  const StateFile opened = StateFile::open_read_only(file);
  CHECK(opened.read_all().size() == 1);
  CHECK(opened.damaged() == 5);
  // Without a checksum, as after another tool's edit, a jet is checked by what it says.
  change(file, "DELETE FROM states WHERE id <> 2");
  change(file, "UPDATE states SET checksum = NULL");
  CHECK_THAT(error_of([&] { load_states(file); }), Contains("s.states", "e004 of a jet is unknown"));
  change(file, "ALTER TABLE states DROP COLUMN e111");
  CHECK_THAT(error_of([&] { load_states(file); }), Contains("has 46 of the 47 columns of jets"));
}

TEST_CASE("a writer killed while jets come loses nothing that it had confirmed") {
  const TemporaryFolder folder;
  const auto file = folder / "s.states";
  int pipe_ends[2];
  REQUIRE(::pipe(pipe_ends) == 0);
  const std::vector<State> all = states_with_jets(40);
  const pid_t child = ::fork();
  if (child == 0) {
    // The child must not return into the test framework.
    StateFile out = StateFile::open_or_create(file, header());
    for (std::size_t i = 0;; ++i) {
      out.append(std::span(all).subspan(i % 40, 1));
      const int durable = static_cast<int>(i + 1);
      if (::write(pipe_ends[1], &durable, sizeof durable) != sizeof durable) ::_exit(1);
    }
  }
  ::close(pipe_ends[1]);
  int durable = 0;
  while (durable < 50 && ::read(pipe_ends[0], &durable, sizeof durable) == sizeof durable) {
  }
  ::kill(child, SIGKILL);
  int last = 0;
  while (::read(pipe_ends[0], &last, sizeof last) == sizeof last) durable = last;
  ::waitpid(child, nullptr, 0);
  ::close(pipe_ends[0]);
  REQUIRE(durable >= 50);
  const LoadedStates loaded = load_states(file);
  CHECK(loaded.damaged == 0);
  REQUIRE(loaded.states.size() >= std::size_t(durable));
  for (std::size_t i = 0; i < loaded.states.size(); ++i) CHECK(same(loaded.states[i], all[i % 40]));
}

TEST_CASE("jets of all orders survive the way through CSV bit for bit") {
  const TemporaryFolder folder;
  const std::vector<State> all = states_with_jets(16);
  write_states_csv(folder / "s.csv", all);
  const std::vector<State> again = read_states_csv(folder / "s.csv");
  REQUIRE(again.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(same(again[i].jet.get(), all[i].jet.get()));
  const std::string text = text_of(folder / "s.csv"), line = text.substr(0, text.find('\n'));
  CHECK_THAT(line, Contains(",energy,e300,e210,e201,"));
  CHECK(line.ends_with(",e014,e005,limit"));
  write_states_csv(folder / "plain.csv", states(4));
  const std::string plain = text_of(folder / "plain.csv");
  CHECK_THAT(plain, !Contains("e300"));
}

TEST_CASE("CSV columns of jets are whole degrees, and the error names the first that is not") {
  const TemporaryFolder folder;
  const std::string head = "x,y,z,fx,fy,fz,";
  const auto refused = [&](const std::string& text, const char* what) {
    const auto file = folder.write("bad.csv", text);
    CHECK_THAT(error_of([&] { read_states_csv(file); }), Contains("bad.csv", what));
  };
  const std::string third = "e300,e210,e201,e120,e111,e102,e030,e021,e012,e003";
  refused(head + "e300,e210,e201,e120,e111,limit\n1,2,3,4,5,6,1,2,3,4,5,6\n",
          "bad.csv:1: no column e102, expected all from e300 to e003 or none");
  refused(head + "e210,limit\n1,2,3,4,5,6,1,1\n", "no column e300");
  refused(head + third + ",e400,limit\n1,2,3,4,5,6,1,2,3,4,5,6,7,8,9,10,11,1\n",
          "no column e310, expected all from e300 to e004");
  refused(head + third + "\n1,2,3,4,5,6,1,2,3,4,5,6,7,8,9,10\n", "no column limit");
  const auto row = [&](const std::string& cells) {
    return head + third + ",limit\n1,2,3,4,5,6," + cells + "\n";
  };
  refused(row("1,2,3,4,,6,7,8,9,10,inf"), "bad.csv:2: column e111 of a jet is unknown");
  refused(row("1,2,3,4,inf,6,7,8,9,10,inf"), "bad.csv:2: column e111: 'inf' is not finite");
  refused(row("1,2,3,4,1e120,6,7,8,9,10,inf"), "bad.csv:2: column e111 of a jet is above 1e+100");
  refused(row("1,2,3,4,5,6,7,8,9,10,"),
          "bad.csv:2: column limit of a jet is nan, expected a distance [m] or inf");
  refused(row("1,2,3,4,5,6,7,8,9,10,-1"), "column limit of a jet is -1");
  const auto good = folder.write("good.csv", row("1,2,3,4,5,6,7,8,9,10,inf") + "1,2,3,4,5,7,,,,,,,,,,,\n");
  const std::vector<State> read = read_states_csv(good);
  REQUIRE(read[0].jet);
  CHECK(read[0].jet->order == 2);
  CHECK(read[0].jet->coefficients[jet_index(0, 0, 3)] == 10);
  CHECK(std::isinf(read[0].jet->limit));
  CHECK(!read[1].jet);
  // A column that is called limit, but belongs to no jet, is another's.
  CHECK(!read_states_csv(folder.write("l.csv", head + "limit\n1,2,3,4,5,6,word\n"))[0].jet);
}

TEST_CASE("messages hold jets, and one that ends too early or is odd is malformed") {
  for (const State& sent : states_with_jets(8)) {
    Packer packer;
    pack(packer, sent);
    const Bytes whole = packer.take();
    Unpacker message(whole);
    CHECK(same(unpack_state(message), sent));
    message.expect_end();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      Unpacker part(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      CHECK_THROWS_AS(unpack_state(part), MalformedMessage);
    }
  }
  State sent = state(1);
  sent.jet = jet(4, 1);
  Packer packer;
  pack(packer, sent);
  Bytes odd = packer.take();
  odd[odd.size() - 1 - 8 * (1 + jet_size)] = 5;  // the order
  Unpacker message(odd);
  CHECK_THROWS_AS(unpack_state(message), MalformedMessage);
}

TEST_CASE("the mean of contradicting states has no jet") {
  std::vector<State> all(3, state(1));
  for (State& s : all) s.jet = jet(2, 1);
  all[1].force *= 2;
  all[2].at *= 2;
  const AveragedStates mean = averaged(all);
  REQUIRE(mean.states.size() == 2);
  CHECK(!mean.states[0].jet);
  CHECK(mean.states[1].jet);
}
