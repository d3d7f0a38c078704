// The queue in front of a state file: many threads, killed processes, failing disks.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "geometry/states/state_file.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

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

TEST_CASE("a killed writer loses nothing that it had flushed, and the file can be appended to") {
  const TemporaryFolder folder;
  const auto file = folder / "s.states";
  int pipe_ends[2];
  REQUIRE(::pipe(pipe_ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    // The child must not return into the test framework.
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
  StateFile again = StateFile::open_or_create(file, header());  // the lock of the killed writer is free
  const std::size_t before = again.size();
  again.append(states(5));
  CHECK(again.size() == before + 5);
}

TEST_CASE("a failing disk is reported by the next push or flush") {
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
      std::chrono::steady_clock::now() + std::chrono::seconds(300);  // a loaded machine may be slow
  while (reader.size() == 0 && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  CHECK(reader.size() == 1);
}

TEST_CASE("parts of a file that a killed process was creating are removed, those of others stay") {
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
  const auto there = [&](const std::string& name) { return fs::exists(folder / name); };
  CHECK(there("s.states"));
  CHECK_FALSE(there("s.states." + gone + ".part"));
  CHECK_FALSE(there("s.states." + gone + ".part-journal"));
  CHECK(there("s.states." + mine + ".part"));
  CHECK(there("other.states." + gone + ".part"));
  CHECK(there("s.states.old.part"));
}
