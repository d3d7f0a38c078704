// State files: values bit for bit, damage, foreign files, one writer.

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include "geometry/states/state_file.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

TEST_CASE("states come back bit for bit, in order, with header") {
  const TemporaryFolder folder;
  std::vector<State> all = states(50);
  all[7].solve.status = SolveStatus::stalled;
  all[7].force = Vec3::Constant(unknown);
  {
    StateFile file = StateFile::open_or_create(folder / "s.states", header());
    file.append(std::span(all).first(20));
    file.append(std::span(all).subspan(20));
    CHECK(file.size() == 50);
  }
  CHECK(folder.entries() == 1);  // log, shared memory and lock are removed
  const StateFile file = StateFile::open_read_only(folder / "s.states");
  CHECK(file.header().identity == header().identity);
  CHECK(file.header().notes == header().notes);
  CHECK(file.header().spacing == 0.006);
  CHECK(file.header().box.low == header().box.low);
  CHECK(file.header().box.high == header().box.high);
  const std::vector<State> again = file.read_all();
  REQUIRE(again.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(same(again[i], all[i]));
}

TEST_CASE("states in any order are put into one: outward from rest, each unchanged") {
  const TemporaryFolder folder;
  std::vector<State> all = states(50), first;
  for (unsigned seed = 0; seed < 3; ++seed) {
    std::ranges::shuffle(all, std::mt19937(seed));
    const fs::path name = folder / fmt::format("{}.states", seed);
    StateFile file = StateFile::open_or_create(name, header());
    file.append(all);
    file.order_outward();
    const std::vector<State> ordered = file.read_all();
    REQUIRE(ordered.size() == all.size());
    if (seed == 0) first = ordered;
    for (std::size_t i = 0; i < all.size(); ++i) {
      CHECK(same(ordered[i], first[i]));
      if (i > 0) CHECK(ordered[i].at.norm() >= ordered[i - 1].at.norm() * (1 - 1e-12));
    }
    CHECK(file.damaged() == 0);
    file.append(std::vector{state(77)});  // goes on behind them
    CHECK(file.size() == 51);
  }
}

TEST_CASE("the columns are plain, unknown values are NULL") {
  const TemporaryFolder folder;
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{state(1), state(2, false)});
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open((folder / "s.states").c_str(), &database) == SQLITE_OK);
  std::string seen;
  const auto row = [](void* out, int n, char** text, char**) {
    for (int i = 0; i < n; ++i)
      *static_cast<std::string*>(out) += std::string(text[i] ? text[i] : "NULL") + " ";
    return 0;
  };
  sqlite3_exec(
      database,
      "SELECT id, status, typeof(k11), typeof(k33), typeof(energy), typeof(displacements) FROM states", row,
      &seen, nullptr);
  sqlite3_exec(database, "PRAGMA journal_mode", row, &seen, nullptr);
  sqlite3_exec(database, "SELECT count(*) FROM states WHERE fx*fx + fy*fy + fz*fz > 0 AND k12 IS NOT k21",
               row, &seen, nullptr);
  sqlite3_close(database);
  CHECK(seen == "1 converged real real real null 2 measured null null null null wal 1 ");
}

namespace {
void change(const fs::path& file, const char* sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  CHECK(sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(database);
}
}  // namespace

TEST_CASE("a row with a wrong checksum is left out, counted, and deleted on demand") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  const std::vector<State> all = states(30);
  StateFile::open_or_create(file, header()).append(all);
  CHECK(StateFile::open_read_only(file).damaged() == 0);
  // Changes one bit of each kind of value, and makes a status an unknown word.
  const char* const changes[] = {"UPDATE states SET x = x + 1e-17 + 1e-15 * abs(x) WHERE id = 2",
                                 "UPDATE states SET k23 = k23 * (1 + 2.3e-16) WHERE id = 5",
                                 "UPDATE states SET iterations = iterations + 1 WHERE id = 7",
                                 "UPDATE states SET multivalued = 1 - multivalued WHERE id = 11",
                                 "UPDATE states SET energy = NULL WHERE id = 13",
                                 "UPDATE states SET status = 'convergee' WHERE id = 17",
                                 "UPDATE states SET checksum = checksum - 1 WHERE id = 30"};
  for (const char* sql : changes) change(file, sql);
  StateFile opened = StateFile::open_or_create(file, header());
  const std::vector<State> left = opened.read_all();
  CHECK(opened.damaged() == 7);
  REQUIRE(left.size() == 23);
  CHECK(same(left[0], all[0]));
  CHECK(same(left[1], all[2]));
  CHECK(load_states(file).damaged == 7);
  CHECK(opened.size() == 30);
  opened.drop_damaged();
  CHECK(opened.size() == 23);
  opened.append(std::span(all).subspan(1, 1));
  CHECK(opened.read_all().size() == 24);
  CHECK(opened.damaged() == 0);
  CHECK_THAT(damage_in_words("a.states", 2, true),
             Catch::Equals("a.states: 2 states have a wrong checksum: left out, to be solved anew"));
}

TEST_CASE("states whose squares overflow and broken pages are refused when states are loaded") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  StateFile::open_or_create(file, header()).append(states(400));
  CHECK_NOTHROW(load_states(file));
  for (const char* column : {"x", "fz", "k31"}) {
    const fs::path far = folder / (std::string(column) + ".states");
    fs::copy_file(file, far);
    change(far,
           ("UPDATE states SET checksum = NULL, " + std::string(column) + " = -1e160 WHERE id = 3").c_str());
    CHECK_THROWS_WITH(load_states(far), Contains(far.string(), "above 1e+100"));
  }
  // The pages of the table, not its first one.
  std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(static_cast<std::streamoff>(fs::file_size(file)) - 3 * 4096);
  bytes << std::string(4096, '\xff');
  bytes.close();
  CHECK_THROWS_WITH(load_states(file), Contains(file.string(), "is damaged or no state file"));
}

TEST_CASE("an older file without checksums is read and can be appended to") {
  const TemporaryFolder folder;
  const fs::path file = folder / "s.states";
  const std::vector<State> all = states(5);
  StateFile::open_or_create(file, header()).append(std::span(all).first(4));
  change(file, "ALTER TABLE states DROP COLUMN checksum");
  const StateFile before = StateFile::open_read_only(file);
  CHECK(before.read_all().size() == 4);
  CHECK(before.damaged() == 0);
  StateFile again = StateFile::open_or_create(file, header());
  again.append(std::span(all).subspan(4));
  change(file,
         "UPDATE states SET fx = 77 WHERE id = 1 OR id = 5");  // only the new row has a checksum
  CHECK(again.read_all().size() == 4);
  CHECK(again.damaged() == 1);
}

TEST_CASE("a file of another body is refused, and the error names the differing keys") {
  const TemporaryFolder folder;
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{state(1)});
  StateFileHeader other = header();
  other.identity["material"] = "sha256 zz";
  other.identity["contact"] = "sha256 dd";
  const std::string line = error_of([&] { StateFile::open_or_create(folder / "s.states", other); });
  CHECK_THAT(line, Contains("belongs to another body"));
  CHECK_THAT(line, Contains("material (file sha256 bb, here sha256 zz)"));
  CHECK_THAT(line, Contains("contact (file none, here sha256 dd)"));
  CHECK_THAT(line, !Contains("mesh"));
  CHECK(StateFile::open_or_create(folder / "s.states", header()).size() == 1);
}

TEST_CASE("states of a body and states that name no body never share a file") {
  const TemporaryFolder folder;
  StateFileHeader nobody = header();
  nobody.identity.clear();
  StateFile::open_or_create(folder / "body.states", header()).append(std::vector{state(1)});
  StateFile::open_or_create(folder / "measured.states", nobody).append(std::vector{state(1), state(2)});
  const std::string before = text_of(folder / "measured.states");
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "body.states", nobody); }),
             Contains("body.states: holds 1 states of a body"));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "measured.states", header()); }),
             Contains("measured.states: holds 2 states that name no body"));
  CHECK(text_of(folder / "measured.states") == before);
  CHECK(StateFile::open_or_create(folder / "measured.states", nobody).size() == 2);
  StateFile::open_or_create(folder / "empty.states", nobody);
  CHECK(StateFile::open_or_create(folder / "empty.states", header()).header().identity == header().identity);
  CHECK(StateFile::open_read_only(folder / "empty.states").header().identity == header().identity);
}

TEST_CASE("what is no state file is refused in one line") {
  const TemporaryFolder folder;
  const auto both = [&](const fs::path& file, const char* text) {
    INFO(file);
    CHECK_THAT(error_of([&] { StateFile::open_read_only(file); }), Contains(text));
  };
  both(folder / "absent.states", "cannot be read: No such file");
  both(folder.path(), "is a folder");
  both(folder.write("empty.states", ""), "is empty");
  both(folder.write("text.states", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n"), "is not a state file");
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "text.states", header()); }),
             Contains("is not a state file"));
  CHECK(text_of(folder / "text.states").starts_with("x,y,z"));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "no/such.states", header()); }),
             Contains("does not exist"));
  sqlite3* database = nullptr;
  sqlite3_open((folder / "other.states").c_str(), &database);
  sqlite3_exec(database, "CREATE TABLE states (x REAL)", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  both(folder / "other.states", "is a database, but not a state file");
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "other.states", header()); }),
             Contains("not a state file"));
}

TEST_CASE("a state file cut or damaged anywhere is refused or read, never worse") {
  const TemporaryFolder folder;
  { StateFile::open_or_create(folder / "s.states", header()).append(states(40)); }
  const std::string good = text_of(folder / "s.states");
  std::mt19937 random(7);
  for (int trial = 0; trial < 150; ++trial) {
    std::string bad = good;
    if (trial % 2)
      bad.resize(random() % good.size());
    else
      for (int k = 0; k < 30; ++k) bad[random() % bad.size()] = static_cast<char>(random());
    const auto file = folder.write("bad.states", bad);
    const std::string line = error_of([&] { StateFile::open_read_only(file).read_all(); });
    CHECK_THAT(line, !Contains("\n"));
    if (trial % 2) CHECK(!line.empty());
    const std::string appended =
        error_of([&] { StateFile::open_or_create(file, header()).append(states(3)); });
    CHECK_THAT(appended, !Contains("\n"));
    for (const char* suffix : {"-wal", "-shm"}) fs::remove(file.string() + suffix);
  }
}

TEST_CASE("one writer at a time, readers beside it") {
  const TemporaryFolder folder;
  StateFile writer = StateFile::open_or_create(folder / "s.states", header());
  writer.append(states(3));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "s.states", header()); }),
             Contains("is being written by another process"));
  const StateFile reader = StateFile::open_read_only(folder / "s.states");
  CHECK(reader.size() == 3);
  writer.append(states(4));
  CHECK(reader.size() == 7);
  CHECK(load_states(folder / "s.states").states.size() == 7);
  StateFile& read_only = const_cast<StateFile&>(reader);
  CHECK_THAT(error_of([&] { read_only.append(states(1)); }), Contains("opened for reading"));
}

TEST_CASE("replacing is one transaction") {
  const TemporaryFolder folder;
  StateFile file = StateFile::open_or_create(folder / "s.states", header());
  file.append(states(5));
  StateFileHeader other;
  other.spacing = 0.01;
  file.replace(other, states(2));
  CHECK(file.size() == 2);
  CHECK(StateFile::open_read_only(folder / "s.states").header().spacing == 0.01);
  CHECK(StateFile::open_read_only(folder / "s.states").header().identity.empty());
}
