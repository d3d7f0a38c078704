// One state file under several names: the lock, SQLite's log, and what a reader sees.

#include "geometry/states/state_file.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

TEST_CASE("a second writer under a hard link is refused, and no state is lost") {
  const TemporaryFolder folder;
  const auto file = folder / "s.states", other = folder / "other.states";
  {
    StateFile writer = StateFile::open_or_create(file, header());
    writer.append(states(3));
    fs::create_hard_link(file, other);
    CHECK_THAT(error_of([&] { StateFile::open_or_create(other, header()); }), Contains("2 names"));
    writer.append(states(4));
    CHECK_THAT(error_of([&] { StateFile::open_read_only(other); }),
               Contains("is being written under another of its names"));
    CHECK(StateFile::open_read_only(file).size() == 7);
  }
  CHECK_THAT(error_of([&] { StateFile::open_or_create(file, header()); }),
             Contains("has 2 names (hard links), expected one"));
  CHECK(StateFile::open_read_only(file).size() == 7);
  CHECK(StateFile::open_read_only(other).size() == 7);  // nothing writes it: all of it is in the file
  CHECK_FALSE(fs::exists(other.string() + "-wal"));
  fs::remove(other);
  CHECK(StateFile::open_or_create(file, header()).size() == 7);
}

TEST_CASE("a symbolic link is the file that it leads to: one writer, one log") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "data");
  fs::create_directory(folder / "links");
  const auto file = folder / "data/s.states", link = folder / "links/l.states";
  fs::create_symlink("../data/s.states", link);  // a link that leads nowhere yet
  {
    StateFile writer = StateFile::open_or_create(link, header());
    writer.append(states(3));
    CHECK(fs::is_regular_file(fs::symlink_status(file)));
    CHECK_THAT(error_of([&] { StateFile::open_or_create(file, header()); }),
               Contains("is being written by another process"));
  }
  CHECK(fs::is_symlink(link));
  StateFile writer = StateFile::open_or_create(file, header());
  CHECK_THAT(error_of([&] { StateFile::open_or_create(link, header()); }),
             Contains("is being written by another process"));
  writer.append(states(4));
  CHECK(StateFile::open_read_only(link).size() == 7);
}
