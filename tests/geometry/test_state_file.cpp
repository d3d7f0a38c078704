#include <catch2/catch.hpp>

#include <signal.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;
using test::TemporaryFolder;

namespace {

StateFileHeader header() {
  StateFileHeader h;
  h.identity = {{"mesh", "sha256 aa"}, {"material", "sha256 bb"}, {"clamp", "sha256 cc"}};
  h.spacing = 0.006;
  h.box = {{-0.036, -0.03, -0.024}, {0.036, 0.03, 0.036}};
  h.notes["scene"] = "[body]\nphantom = \"liver\"\n";
  return h;
}

State state(int i, bool full = true) {
  std::mt19937 random(static_cast<unsigned>(i));
  std::uniform_real_distribution<double> uniform(-1, 1);
  State s;
  s.at = {uniform(random), uniform(random), i * 1e-3};
  s.force = {uniform(random), uniform(random), uniform(random)};
  if (!full) return s;
  for (int k = 0; k < 9; ++k) s.stiffness(k / 3, k % 3) = 100 * uniform(random);
  s.energy = uniform(random), s.spacing = 0.012, s.status = SolveStatus::converged,
  s.multivalued = i % 2 == 1;
  s.iterations = i, s.residual = 1e-11, s.seconds = 0.004, s.min_jacobian = 0.7;
  s.parent = {0.1, 0.2, uniform(random)};
  if (i % 3 == 0)
    s.displacements =
        std::make_shared<const std::vector<double>>(std::vector<double>{1, 2, 3, uniform(random), 5, 6});
  return s;
}

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}
bool same(const Vec3& a, const Vec3& b) {
  return same(a[0], b[0]) && same(a[1], b[1]) && same(a[2], b[2]);
}

bool same(const State& a, const State& b) {
  for (int k = 0; k < 9; ++k)
    if (!same(a.stiffness(k / 3, k % 3), b.stiffness(k / 3, k % 3))) return false;
  const bool displaced =
      a.displacements ? b.displacements && *a.displacements == *b.displacements : !b.displacements;
  return same(a.at, b.at) && same(a.force, b.force) && same(a.energy, b.energy) &&
         same(a.spacing, b.spacing) && a.status == b.status && a.multivalued == b.multivalued &&
         a.iterations == b.iterations && same(a.residual, b.residual) && same(a.seconds, b.seconds) &&
         same(a.min_jacobian, b.min_jacobian) && same(a.parent, b.parent) && displaced;
}

std::vector<State> states(int n) {
  std::vector<State> all;
  for (int i = 0; i < n; ++i) all.push_back(state(i, i % 4 != 3));
  return all;
}

std::string error_of(auto&& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string content_of(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

}  // namespace

TEST_CASE("states come back bit for bit, in order, with header") {
  const TemporaryFolder folder;
  std::vector<State> all = states(50);
  all[7].status = SolveStatus::stalled;
  all[7].force = Vec3::Constant(unknown);
  {
    StateFile file = StateFile::open_or_create(folder / "s.states", header());
    file.append(std::span(all).first(20));
    file.append(std::span(all).subspan(20));
    CHECK(file.size() == 50);
  }
  CHECK(folder.entries() == 1);  // log, shared memory and lock are gone
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
void change(const std::filesystem::path& file, const char* sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  CHECK(sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(database);
}
}  // namespace

TEST_CASE("a row that is not what was written is left out, said, and taken out on demand") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "s.states";
  const std::vector<State> all = states(30);
  StateFile::open_or_create(file, header()).append(all);
  CHECK(StateFile::open_read_only(file).damaged() == 0);
  // One bit of each kind of value, and a word that is no status any more.
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
  const std::filesystem::path file = folder / "s.states";
  StateFile::open_or_create(file, header()).append(states(400));
  CHECK_NOTHROW(load_states(file));
  for (const char* column : {"x", "fz", "k31"}) {
    const std::filesystem::path far = folder / (std::string(column) + ".states");
    std::filesystem::copy_file(file, far);
    change(far,
           ("UPDATE states SET checksum = NULL, " + std::string(column) + " = -1e160 WHERE id = 3").c_str());
    CHECK_THROWS_WITH(load_states(far), Catch::Contains(far.string()) && Catch::Contains("above 1e+100"));
  }
  // The pages of the table, not its first one.
  std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(static_cast<std::streamoff>(std::filesystem::file_size(file)) - 3 * 4096);
  bytes << std::string(4096, '\xff');
  bytes.close();
  CHECK_THROWS_WITH(load_states(file),
                    Catch::Contains(file.string()) && Catch::Contains("is damaged or no state file"));
}

TEST_CASE("a file of before, without checksums, is read and gone on with") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "s.states";
  const std::vector<State> all = states(5);
  StateFile::open_or_create(file, header()).append(std::span(all).first(4));
  change(file, "ALTER TABLE states DROP COLUMN checksum");
  const StateFile before = StateFile::open_read_only(file);
  CHECK(before.read_all().size() == 4);
  CHECK(before.damaged() == 0);
  StateFile again = StateFile::open_or_create(file, header());
  again.append(std::span(all).subspan(4));
  change(file,
         "UPDATE states SET fx = 77 WHERE id = 1 OR id = 5");  // only the new one can be known for wrong
  CHECK(again.read_all().size() == 4);
  CHECK(again.damaged() == 1);
}

TEST_CASE("a file of another body is refused with what differs") {
  const TemporaryFolder folder;
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{state(1)});
  StateFileHeader other = header();
  other.identity["material"] = "sha256 zz";
  other.identity["contact"] = "sha256 dd";
  const std::string line = error_of([&] { StateFile::open_or_create(folder / "s.states", other); });
  CHECK(line.find("belongs to another body") != std::string::npos);
  CHECK(line.find("material (file sha256 bb, here sha256 zz)") != std::string::npos);
  CHECK(line.find("contact (file none, here sha256 dd)") != std::string::npos);
  CHECK(line.find("mesh") == std::string::npos);
  CHECK(StateFile::open_or_create(folder / "s.states", {}).size() == 1);  // no identity asks nothing
  CHECK(StateFile::open_or_create(folder / "s.states", header()).size() == 1);
}

TEST_CASE("what is no state file is refused in one line") {
  const TemporaryFolder folder;
  const auto both = [&](const std::filesystem::path& file, const char* text) {
    INFO(file);
    CHECK_THAT(error_of([&] { StateFile::open_read_only(file); }), Catch::Contains(text));
  };
  both(folder / "absent.states", "cannot be read: No such file");
  both(folder.path(), "is a folder");
  both(folder.write("empty.states", ""), "is empty");
  both(folder.write("text.states", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n"), "is not a state file");
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "text.states", header()); }),
             Catch::Contains("is not a state file"));
  CHECK(content_of(folder / "text.states").starts_with("x,y,z"));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "no/such.states", header()); }),
             Catch::Contains("does not exist"));
  sqlite3* database = nullptr;
  sqlite3_open((folder / "other.states").c_str(), &database);
  sqlite3_exec(database, "CREATE TABLE states (x REAL)", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  both(folder / "other.states", "is a database, but not a state file");
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "other.states", header()); }),
             Catch::Contains("not a state file"));
}

TEST_CASE("a state file cut or damaged anywhere is refused or read, never worse") {
  const TemporaryFolder folder;
  { StateFile::open_or_create(folder / "s.states", header()).append(states(40)); }
  const std::string good = content_of(folder / "s.states");
  std::mt19937 random(7);
  for (int trial = 0; trial < 150; ++trial) {
    std::string bad = good;
    if (trial % 2)
      bad.resize(random() % good.size());
    else
      for (int k = 0; k < 30; ++k) bad[random() % bad.size()] = static_cast<char>(random());
    const auto file = folder.write("bad.states", bad);
    const std::string line = error_of([&] { StateFile::open_read_only(file).read_all(); });
    CHECK(line.find('\n') == std::string::npos);
    if (trial % 2) CHECK(!line.empty());
    const std::string appended =
        error_of([&] { StateFile::open_or_create(file, header()).append(states(3)); });
    CHECK(appended.find('\n') == std::string::npos);
    for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(file.string() + suffix);
  }
}

TEST_CASE("one writer at a time, readers beside it") {
  const TemporaryFolder folder;
  StateFile writer = StateFile::open_or_create(folder / "s.states", header());
  writer.append(states(3));
  CHECK_THAT(error_of([&] { StateFile::open_or_create(folder / "s.states", header()); }),
             Catch::Contains("is being written by another process"));
  const StateFile reader = StateFile::open_read_only(folder / "s.states");
  CHECK(reader.size() == 3);
  writer.append(states(4));
  CHECK(reader.size() == 7);
  CHECK(load_states(folder / "s.states").states.size() == 7);
  StateFile& read_only = const_cast<StateFile&>(reader);
  CHECK_THAT(error_of([&] { read_only.append(states(1)); }), Catch::Contains("opened for reading"));
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

TEST_CASE("many threads push, everything is written once") {
  for (const int threads : {1, 2, 3, 7}) {
    const TemporaryFolder folder;
    constexpr int each = 200;
    {
      StateWriter writer(StateFile::open_or_create(folder / "s.states", header()));
      std::vector<std::thread> pool;
      for (int t = 0; t < threads; ++t)
        pool.emplace_back([&writer, t] {
          for (int i = 0; i < each; ++i) {
            State s;
            s.at = {double(t), double(i), 0}, s.force = s.at;
            writer.push(s);
            if (i % 50 == 49) writer.flush();
          }
        });
      for (std::thread& thread : pool) thread.join();
      writer.flush();
      CHECK(StateFile::open_read_only(folder / "s.states").size() == std::size_t(threads * each));
    }
    std::vector<int> next(std::size_t(threads), 0);
    for (const State& s : StateFile::open_read_only(folder / "s.states").read_all())
      CHECK(int(s.at.y()) == next[std::size_t(s.at.x())]++);
  }
}

TEST_CASE("a kill loses nothing that was flushed, and the file goes on") {
  const TemporaryFolder folder;
  const auto file = folder / "s.states";
  int pipe_ends[2];
  REQUIRE(::pipe(pipe_ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    // Only plain work from here: the parent's test framework must not run twice.
    StateWriter writer(StateFile::open_or_create(file, header()));
    for (int i = 0;; ++i) {
      writer.push(state(i));
      if (i % 10 != 9) continue;
      writer.flush();
      const int durable = i + 1;
      if (::write(pipe_ends[1], &durable, sizeof durable) != sizeof durable) ::_exit(1);
    }
  }
  ::close(pipe_ends[1]);
  int durable = 0;
  while (durable < 200 && ::read(pipe_ends[0], &durable, sizeof durable) == sizeof durable) {
  }
  ::kill(child, SIGKILL);
  int last = 0;
  while (::read(pipe_ends[0], &last, sizeof last) == sizeof last)
    durable = last;  // confirmed before the kill
  ::waitpid(child, nullptr, 0);
  ::close(pipe_ends[0]);
  REQUIRE(durable >= 200);
  {
    const StateFile read = StateFile::open_read_only(file);
    const std::vector<State> all = read.read_all();
    REQUIRE(all.size() >= std::size_t(durable));
    for (std::size_t i = 0; i < all.size(); ++i) CHECK(same(all[i], state(int(i))));
  }
  StateFile again = StateFile::open_or_create(file, header());  // the dead writer's lock does not hold
  const std::size_t before = again.size();
  again.append(states(5));
  CHECK(again.size() == before + 5);
}

TEST_CASE("a failing disk is told at the next push or flush") {
  const TemporaryFolder folder;
  StateWriter writer(StateFile::open_or_create(folder / "s.states", header()));
  State broken;
  broken.at = Vec3::Constant(unknown);  // x is NOT NULL
  writer.push(broken);
  CHECK_THROWS_AS(writer.flush(), InputError);
  CHECK_THROWS_AS(writer.push(state(1)), InputError);
}

TEST_CASE("states are on disk soon after the push, without a flush") {
  const TemporaryFolder folder;
  StateWriter writer(StateFile::open_or_create(folder / "s.states", header()));
  writer.push(state(1));
  const StateFile reader = StateFile::open_read_only(folder / "s.states");
  const auto give_up =
      std::chrono::steady_clock::now() + std::chrono::seconds(30);  // a loaded machine may be slow
  while (reader.size() == 0 && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  CHECK(reader.size() == 1);
}

TEST_CASE(
    "what a killed process left of a file that it was making is swept, what lives or is another's is not") {
  const TemporaryFolder folder;
  const auto file = folder / "s.states";
  const pid_t dead = ::fork();
  if (dead == 0) ::_exit(0);
  ::waitpid(dead, nullptr, 0);
  const auto put = [&](const std::string& name) { std::ofstream(folder / name) << "x"; };
  const std::string gone = std::to_string(dead), mine = std::to_string(::getppid());
  put("s.states." + gone + ".part");
  put("s.states." + gone + ".part-journal");
  put("s.states." + mine + ".part");
  put("other.states." + gone + ".part");
  put("s.states.old.part");
  StateFile::open_or_create(file, header());
  const auto there = [&](const std::string& name) { return std::filesystem::exists(folder / name); };
  CHECK(there("s.states"));
  CHECK_FALSE(there("s.states." + gone + ".part"));
  CHECK_FALSE(there("s.states." + gone + ".part-journal"));
  CHECK(there("s.states." + mine + ".part"));
  CHECK(there("other.states." + gone + ".part"));
  CHECK(there("s.states.old.part"));
}
