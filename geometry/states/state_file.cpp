#include "geometry/states/state_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <mutex>
#include <thread>

#include "geometry/common/error.hpp"
#include "geometry/common/link_target.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/sqlite_handle.hpp"
#include "geometry/states/state_rows.hpp"
#include "geometry/states/writer_lock.hpp"

namespace forefeel {

namespace fs = std::filesystem;
using sqlite::Database;
using sqlite::execute;
using sqlite::open_database;
using sqlite::Statement;

namespace {

void check_signature(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    throw InputError({.file = file.string()}, "is a folder, expected a state file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError({.file = file.string()}, fmt::format("cannot be read: {}", std::strerror(errno)));
  char head[16] = {};
  in.read(head, sizeof head);
  if (in.gcount() == 0) throw InputError({.file = file.string()}, "is empty, expected a state file");
  if (in.gcount() != sizeof head || std::memcmp(head, "SQLite format 3", sizeof head) != 0)
    throw InputError({.file = file.string()},
                     "is not a state file, expected a SQLite database written by forefeel");
}

// Removes NAME.PID.part and its journal if the process PID has ended without doing so.
void sweep_parts(const fs::path& file) {
  std::error_code error;
  const std::string prefix = file.filename().string() + ".";
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string found = entry.path().filename().string();
    if (!found.starts_with(prefix)) continue;
    int process = 0;
    const char* const end = found.data() + found.size();
    const auto [rest, bad] = std::from_chars(found.data() + prefix.size(), end, process);
    if (bad != std::errc{} || process <= 0 || !std::string_view(rest, end).starts_with(".part")) continue;
    if (::kill(process, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), error);
  }
}

// Creates the file under a temporary name and renames it: it never exists without its tables and identity.
void create(const fs::path& file, const StateFileHeader& header) {
  const std::string where = file.string(), temporary = fmt::format("{}.{}.part", where, ::getpid());
  std::error_code ignored;
  sweep_parts(file);
  fs::remove(temporary, ignored);
  try {
    const Database database = open_database(temporary, where, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    create_tables(database.get(), where, header);
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
  if (::rename(temporary.c_str(), where.c_str()) != 0) {
    const int error = errno;
    fs::remove(temporary, ignored);
    throw InputError({.file = where}, fmt::format("cannot be written: {}", std::strerror(error)));
  }
}

// Refuses to mix states of a known body with states without an identity. A file without states takes the identity.
void check_owner(sqlite3* database, const std::string& where, StateFileHeader& in_file,
                 const BodyIdentity& ours) {
  check_same_body(where, in_file.identity, ours);
  if (in_file.identity.empty() == ours.empty()) return;
  Statement count(database, where, "SELECT count(*) FROM states");
  count.step();
  if (count.integer(0) > 0 && ours.empty())
    throw InputError(
        {.file = where},
        fmt::format("holds {} states of a body, expected a file of its own for states without one",
                    count.integer(0)));
  if (count.integer(0) > 0)
    throw InputError(
        {.file = where},
        fmt::format("holds {} states that name no body (imported or measured), expected a state file of this "
                    "body, or a new name",
                    count.integer(0)));
  if (ours.empty()) return;
  execute(database, where, "BEGIN IMMEDIATE");
  Statement insert(database, where, "INSERT INTO identity (key, value) VALUES (?, ?)");
  for (const auto& [key, value] : ours) {
    insert.bind(1, std::string_view(key));
    insert.bind(2, std::string_view(value));
    insert.step();
    insert.reset();
  }
  execute(database, where, "COMMIT");
  in_file.identity = ours;
}

}  // namespace

struct StateFile::Impl {
  std::string where;
  std::unique_ptr<WriterLock> lock;  // destroyed after the database is closed
  Database database;
  StateFileHeader header;
  bool checksums = true;              // whether the table has the column
  std::vector<std::int64_t> damaged;  // ids
};

StateFile::StateFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StateFile::~StateFile() = default;
StateFile::StateFile(StateFile&&) noexcept = default;
StateFile& StateFile::operator=(StateFile&&) noexcept = default;

StateFile StateFile::open_or_create(const fs::path& name, const StateFileHeader& header) {
  check_appendable(name);
  const fs::path file = followed(name);
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error))
    throw InputError({.file = file.string()}, "is no file, expected a state file or a new name");
  auto impl = std::make_unique<Impl>();
  impl->where = file.string();
  if (fs::file_size(file, error) > 0 && !error) check_signature(file);
  impl->lock = std::make_unique<WriterLock>(file);
  if (!fs::exists(file) || fs::file_size(file, error) == 0) create(file, header);
  impl->lock->take_file();
  impl->database = open_database(impl->where, impl->where, SQLITE_OPEN_READWRITE);
  check_schema(impl->database.get(), impl->where);
  impl->header = read_header(impl->database.get(), impl->where);
  check_owner(impl->database.get(), impl->where, impl->header, header.identity);
  execute(impl->database.get(), impl->where, "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
  if (!has_checksums(impl->database.get(), impl->where))
    execute(impl->database.get(), impl->where, "ALTER TABLE states ADD COLUMN checksum INTEGER");
  // The file keeps the finest spacing that any caller wanted; labels are measured in it.
  if (header.spacing < impl->header.spacing) {
    execute(impl->database.get(), impl->where,
            fmt::format("UPDATE header SET value = {} WHERE key = 'spacing'", header.spacing).c_str());
    impl->header.spacing = header.spacing;
  }
  return StateFile(std::move(impl));
}

namespace {

// Opens for reading. If file and folder are writable, SQLite may recover the log of a killed writer; otherwise nothing
// is changed.
Database open_reader(const fs::path& given) {
  const fs::path file = followed(given);
  const std::string where = file.string();
  const auto attempt = [&](const std::string& name, int flags) {
    Database database = open_database(name, where, flags);
    execute(database.get(), where, "PRAGMA query_only = 1");
    check_schema(database.get(), where);
    return database;
  };
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  // SQLite finds its log by the name of the file. Under another name (hard link), only the states up to the end of the
  // last writer are visible.
  const bool other_name = names_of(file) > 1 && !fs::exists(where + "-wal");
  if (other_name && is_being_written(file))
    throw InputError({.file = given.string()},
                     "is being written under another of its names (hard links), expected that name");
  if (!other_name && ::access(folder.c_str(), W_OK) == 0 && ::access(file.c_str(), W_OK) == 0)
    return attempt(where, SQLITE_OPEN_READWRITE);
  if (!other_name && fs::exists(where + "-wal")) return attempt(where, SQLITE_OPEN_READONLY);
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string())
    uri += c == '%' || c == '?' || c == '#' ? fmt::format("%{:02x}", static_cast<unsigned>(c))
                                            : std::string(1, c);
  return attempt(uri + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
}

}  // namespace

StateFile StateFile::open_read_only(const fs::path& file) {
  check_signature(file);
  auto impl = std::make_unique<Impl>();
  impl->where = file.string();
  impl->database = open_reader(file);
  impl->header = read_header(impl->database.get(), impl->where);
  impl->checksums = has_checksums(impl->database.get(), impl->where);
  return StateFile(std::move(impl));
}

const StateFileHeader& StateFile::header() const {
  return impl_->header;
}

std::vector<State> StateFile::read_all() const {
  std::vector<State> states;
  impl_->damaged.clear();
  for (StateRows rows(impl_->database.get(), impl_->where, impl_->checksums); rows.next();) {
    if (std::optional<State> state = rows.read()) {
      if (state->usable() && !state->force.allFinite() && !impl_->header.notes.contains(tells_note))
        throw InputError({.file = impl_->where}, "a state has a force that is not finite");
      states.push_back(*std::move(state));
    } else {
      impl_->damaged.push_back(rows.id());
    }
  }
  return states;
}

std::string damage_in_words(const std::string& file, std::size_t damaged, bool solved_anew) {
  return fmt::format("{}: {} a wrong checksum: left out{}", file,
                     damaged == 1 ? "1 state has" : fmt::format("{} states have", damaged),
                     solved_anew ? ", to be solved anew" : "");
}

void StateFile::check_pages() const {
  const StepLimit limit(impl_->database.get());
  Statement check(impl_->database.get(), impl_->where, "PRAGMA quick_check(1)");
  if (!check.step() || check.text(0) != "ok")
    throw InputError({.file = impl_->where},
                     fmt::format("is damaged or no state file ({:.80})", check.text(0)));
}

std::size_t StateFile::damaged() const {
  return impl_->damaged.size();
}

std::size_t StateFile::size() const {
  Statement count(impl_->database.get(), impl_->where, "SELECT count(*) FROM states");
  count.step();
  return static_cast<std::size_t>(count.integer(0));
}

namespace {

// Runs work() as one transaction; rolled back if work() throws.
template <class Work>
void transact(sqlite3* database, const std::string& where, Work&& work) {
  execute(database, where, "BEGIN IMMEDIATE");
  try {
    work();
    execute(database, where, "COMMIT");
  } catch (...) {
    sqlite3_exec(database, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

}  // namespace

void StateFile::append(std::span<const State> states) {
  if (states.empty()) return;
  if (!impl_->lock)
    throw InputError({.file = impl_->where}, "was opened for reading, expected a file opened for appending");
  transact(impl_->database.get(), impl_->where,
           [&] { insert_states(impl_->database.get(), impl_->where, states); });
}

void StateFile::drop_damaged() {
  if (impl_->damaged.empty()) return;
  if (!impl_->lock)
    throw InputError({.file = impl_->where}, "was opened for reading, expected a file opened for appending");
  sqlite3* database = impl_->database.get();
  transact(database, impl_->where, [&] {
    Statement remove(database, impl_->where, "DELETE FROM states WHERE id = ?");
    for (const std::int64_t id : impl_->damaged) remove.bind(1, id), remove.step(), remove.reset();
  });
  impl_->damaged.clear();
}

void StateFile::order_outward() {
  sqlite3* database = impl_->database.get();
  transact(database, impl_->where, [&] {
    execute(database, impl_->where,
            "CREATE TEMP TABLE place AS SELECT id, row_number() OVER (ORDER BY x*x + y*y + z*z, x, y, z, id) "
            "AS n "
            "FROM states; CREATE UNIQUE INDEX temp.place_of ON place (id); "
            "UPDATE states SET id = -(SELECT n FROM place WHERE place.id = states.id); "
            "UPDATE states SET id = -id; DROP TABLE place");
  });
}

void StateFile::replace(const StateFileHeader& header, std::span<const State> states) {
  if (!impl_->lock)
    throw InputError({.file = impl_->where}, "was opened for reading, expected a file opened for appending");
  sqlite3* database = impl_->database.get();
  transact(database, impl_->where, [&] {
    execute(database, impl_->where,
            "DELETE FROM states; DELETE FROM identity; DELETE FROM header; DELETE FROM notes");
    write_header(database, impl_->where, header);
    insert_states(database, impl_->where, states);
  });
  impl_->header = header;
}

struct StateWriter::Impl {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds patience{20};

  StateFile file;  // used by the background thread only
  std::mutex mutex;
  std::condition_variable wake, done;
  std::vector<State> waiting;
  Clock::time_point first_waiting;
  std::size_t pushed = 0, written = 0;
  bool hurry = false, stop = false;
  std::exception_ptr failure;
  std::thread thread;

  explicit Impl(StateFile opened) : file(std::move(opened)), thread([this] { run(); }) {}
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    wake.notify_one();
    thread.join();
  }

  void run() {
    std::vector<State> batch;
    std::unique_lock lock(mutex);
    for (;;) {
      wake.wait(lock, [&] { return stop || !waiting.empty(); });
      if (waiting.empty()) return;
      // Waits for more states: they share one flush to the disk.
      wake.wait_until(lock, first_waiting + patience, [&] { return stop || hurry; });
      batch.swap(waiting);
      hurry = false;
      lock.unlock();
      std::exception_ptr problem;
      try {
        file.append(batch);
      } catch (...) {
        problem = std::current_exception();
      }
      lock.lock();
      if (!problem) written += batch.size();
      batch.clear();
      if (problem) failure = problem, waiting.clear();
      done.notify_all();
      if (problem) return;
    }
  }
};

StateWriter::StateWriter(StateFile file) : impl_(std::make_unique<Impl>(std::move(file))) {}
StateWriter::~StateWriter() = default;
StateWriter::StateWriter(StateWriter&&) noexcept = default;
StateWriter& StateWriter::operator=(StateWriter&&) noexcept = default;

void StateWriter::push(State state) {
  bool first = false;
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->failure) std::rethrow_exception(impl_->failure);
    first = impl_->waiting.empty();
    if (first) impl_->first_waiting = Impl::Clock::now();
    impl_->waiting.push_back(std::move(state));
    ++impl_->pushed;
  }
  if (first) impl_->wake.notify_one();  // the thread sees further states without a signal
}

std::size_t StateWriter::written() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->written;
}

void StateWriter::flush() {
  std::unique_lock lock(impl_->mutex);
  const std::size_t all = impl_->pushed;
  impl_->hurry = !impl_->waiting.empty();
  impl_->wake.notify_one();
  impl_->done.wait(lock, [&] { return impl_->failure || impl_->written >= all; });
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

}  // namespace forefeel
