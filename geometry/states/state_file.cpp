#include "geometry/states/state_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>

#include "geometry/common/output_file.hpp"
#include "geometry/states/sqlite_handle.hpp"

namespace forefeel {

namespace fs = std::filesystem;

[[noreturn]] void fail_database(sqlite3* database, const std::string& where) {
  const int code = sqlite3_errcode(database) & 0xff;
  const char* meaning = code == SQLITE_CORRUPT || code == SQLITE_NOTADB ? "is damaged or no state file"
                        : code == SQLITE_BUSY || code == SQLITE_LOCKED  ? "is in use by another process"
                        : code == SQLITE_FULL     ? "cannot be written, the disk is full"
                        : code == SQLITE_READONLY ? "cannot be written, it is read-only"
                        : code == SQLITE_IOERR    ? "cannot be read or written"
                                                  : "is not a usable state file";
  throw InputError({.file = where}, fmt::format("{} ({})", meaning, sqlite3_errmsg(database)));
}

Database open_database(const std::string& name, const std::string& where, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  Database database(raw);
  if (!database) throw InputError({.file = where}, "cannot be opened, no memory");
  if (code != SQLITE_OK) fail_database(database.get(), where);
  sqlite3_busy_timeout(database.get(), 5000);
  return database;
}

void execute(sqlite3* database, const std::string& where, const char* sql) {
  if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail_database(database, where);
}

namespace {

constexpr int application_id = 0x46465331;  // "FFS1"
constexpr int schema_version = 1;

constexpr const char* schema = R"sql(
CREATE TABLE identity (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE header (key TEXT PRIMARY KEY, value REAL);
CREATE TABLE notes (key TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE states (
  id INTEGER PRIMARY KEY,
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  fx REAL, fy REAL, fz REAL,
  k11 REAL, k12 REAL, k13 REAL, k21 REAL, k22 REAL, k23 REAL, k31 REAL, k32 REAL, k33 REAL,
  energy REAL, h REAL, status TEXT NOT NULL, multivalued INTEGER NOT NULL,
  iterations INTEGER NOT NULL, residual REAL, seconds REAL, min_jacobian REAL,
  parent_x REAL, parent_y REAL, parent_z REAL, displacements BLOB, checksum INTEGER);
)sql";

constexpr const char* columns =
    "x, y, z, fx, fy, fz, k11, k12, k13, k21, k22, k23, k31, k32, k33, energy, h, status, multivalued, "
    "iterations, "
    "residual, seconds, min_jacobian, parent_x, parent_y, parent_z, displacements";
constexpr const char* insert_values = "?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?";
constexpr std::array<const char*, 6> box_keys{"box_low_x",  "box_low_y",  "box_low_z",
                                              "box_high_x", "box_high_y", "box_high_z"};

// Held as long as the file is open for appending: one writer at a time. A file of its own beside the database, since
// closing any descriptor of the database would drop SQLite's own locks. The lock dies with its process.
class WriterLock {
 public:
  explicit WriterLock(const fs::path& file) : path_(file.string() + "-lock") {
    for (;;) {
      descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (descriptor_ < 0)
        throw InputError({.file = file.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
      if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
        const int error = errno;
        const std::string owner = read_owner();
        ::close(descriptor_);
        throw InputError(
            {.file = file.string()},
            error == EWOULDBLOCK
                ? fmt::format("is being written by another process{}, expected one writer", owner)
                : fmt::format("cannot be locked: {}", std::strerror(error)));
      }
      // The last owner may have removed the name between open and flock: then we hold a file nobody else will find.
      struct stat ours {
      }, named{};
      if (::fstat(descriptor_, &ours) == 0 && ::stat(path_.c_str(), &named) == 0 &&
          ours.st_ino == named.st_ino && ours.st_dev == named.st_dev)
        break;
      ::close(descriptor_);
    }
    const std::string owner = fmt::format("{}\n", ::getpid());
    if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, owner.data(), owner.size(), 0) < 0) {
      // Only the number in another process's message would be missing.
    }
  }
  ~WriterLock() {
    ::unlink(path_.c_str());
    ::close(descriptor_);
  }
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  std::string read_owner() const {
    char text[32] = {};
    const ssize_t n = ::pread(descriptor_, text, sizeof text - 1, 0);
    return n > 1 ? fmt::format(" ({})", std::string(text, static_cast<std::size_t>(n) - 1)) : std::string();
  }

  std::string path_;
  int descriptor_ = -1;
};

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

void check_schema(sqlite3* database, const std::string& where) {
  Statement id(database, where, "PRAGMA application_id");
  if (!id.step() || id.integer(0) != application_id)
    throw InputError({.file = where}, "is a database, but not a state file");
  Statement version(database, where, "PRAGMA user_version");
  if (!version.step() || version.integer(0) != schema_version)
    throw InputError({.file = where},
                     fmt::format("has schema version {}, expected {}", version.integer(0), schema_version));
  Statement probe(database, where, fmt::format("SELECT {} FROM states LIMIT 0", columns).c_str());
  probe.step();
}

StateFileHeader read_header(sqlite3* database, const std::string& where) {
  StateFileHeader header;
  for (auto [table, target] : {std::pair("identity", &header.identity), std::pair("notes", &header.notes)}) {
    Statement rows(database, where, fmt::format("SELECT key, value FROM {}", table).c_str());
    while (rows.step()) (*target)[std::string(rows.text(0))] = std::string(rows.text(1));
  }
  Statement numbers(database, where, "SELECT key, value FROM header");
  while (numbers.step()) {
    if (numbers.text(0) == "spacing") header.spacing = numbers.real(1);
    for (Eigen::Index i = 0; i < 6; ++i)
      if (numbers.text(0) == box_keys[static_cast<std::size_t>(i)])
        (i < 3 ? header.box.low[i] : header.box.high[i - 3]) = numbers.real(1);
  }
  return header;
}

void write_header(sqlite3* database, const std::string& where, const StateFileHeader& header) {
  for (auto [table, source] : {std::pair("identity", &header.identity), std::pair("notes", &header.notes)}) {
    Statement insert(database, where, fmt::format("INSERT INTO {} VALUES (?, ?)", table).c_str());
    for (const auto& [key, value] : *source) {
      insert.bind(1, std::string_view(key)), insert.bind(2, std::string_view(value));
      insert.step(), insert.reset();
    }
  }
  Statement insert(database, where, "INSERT INTO header VALUES (?, ?)");
  const auto put = [&](std::string_view key, double value) {
    insert.bind(1, key), insert.bind(2, value);
    insert.step(), insert.reset();
  };
  put("spacing", header.spacing);
  for (Eigen::Index i = 0; i < 6; ++i)
    put(box_keys[static_cast<std::size_t>(i)], i < 3 ? header.box.low[i] : header.box.high[i - 3]);
}

// What a process that is no more left of such a file: NAME.PID.part and its journal.
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

// Made whole under a temporary name: whoever finds the file finds its tables and its identity.
void create(const fs::path& file, const StateFileHeader& header) {
  const std::string where = file.string(), temporary = fmt::format("{}.{}.part", where, ::getpid());
  std::error_code ignored;
  sweep_parts(file);
  fs::remove(temporary, ignored);
  try {
    const Database database = open_database(temporary, where, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    execute(database.get(), where,
            fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}; BEGIN", application_id,
                        schema_version)
                .c_str());
    execute(database.get(), where, schema);
    write_header(database.get(), where, header);
    execute(database.get(), where, "COMMIT");
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

std::string shown(const BodyIdentity& identity, const std::string& key) {
  const auto found = identity.find(key);
  if (found == identity.end()) return "none";
  const bool digest =
      found->second.find("sha256") != std::string::npos;  // a person compares its beginning at most
  return digest && found->second.size() > 24 ? found->second.substr(0, 24) + "…" : found->second;
}

}  // namespace

void check_same_body(const std::string& where, const BodyIdentity& in_file, const BodyIdentity& ours) {
  if (ours.empty() || in_file.empty()) return;
  BodyIdentity keys = in_file;
  keys.insert(ours.begin(), ours.end());
  std::string differs;
  for (const auto& [key, value] : keys) {
    const auto a = in_file.find(key), b = ours.find(key);
    if (a != in_file.end() && b != ours.end() && a->second == b->second) continue;
    differs += fmt::format("{}{} (file {}, here {})", differs.empty() ? "" : ", ", key, shown(in_file, key),
                           shown(ours, key));
  }
  if (!differs.empty())
    throw InputError({.file = where}, fmt::format("belongs to another body, different: {}", differs));
}

namespace {

State read_row(Statement& row, const std::string& where) {
  State state;
  int i = 0;
  for (int k = 0; k < 3; ++k) state.at[k] = row.real(i++);
  for (int k = 0; k < 3; ++k) state.force[k] = row.real(i++);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) state.stiffness(r, c) = row.real(i++);
  state.energy = row.real(i++);
  state.spacing = row.real(i++);
  const std::optional<SolveStatus> status = solve_status(row.text(i++));
  if (!status)
    throw InputError({.file = where},
                     fmt::format("a state has the unknown status '{:.20}'", row.text(i - 1)));
  state.status = *status;
  state.multivalued = row.integer(i++) != 0;
  state.iterations = static_cast<int>(row.integer(i++));
  state.residual = row.real(i++);
  state.seconds = row.real(i++);
  state.min_jacobian = row.real(i++);
  for (int k = 0; k < 3; ++k) state.parent[k] = row.real(i++);
  if (const std::string_view bytes = row.bytes(i); !bytes.empty()) {
    if (bytes.size() % (3 * sizeof(double)) != 0)
      throw InputError({.file = where}, "a state's displacements are cut short");
    std::vector<double> displacements(bytes.size() / sizeof(double));
    std::memcpy(displacements.data(), bytes.data(), bytes.size());
    state.displacements = std::make_shared<const std::vector<double>>(std::move(displacements));
  }
  if (!state.at.allFinite() || (state.usable() && !state.force.allFinite()))
    throw InputError({.file = where}, "a state has a position or force that is not finite");
  static constexpr double largest_number = 1e100;  // squares must not overflow
  const auto too_large = [](const auto& values) { return (values.array().abs() > largest_number).any(); };
  if (too_large(state.at) || too_large(state.force) || too_large(state.stiffness))
    throw InputError({.file = where},
                     fmt::format("a position, force or stiffness is above {:g} in size, expected SI units",
                                 largest_number));
  return state;
}

// Of all that a row holds, as it is read again: one unknown, one zero. Each step is a bijection of what is known so far, so
// that no single change of a value goes unseen.
std::int64_t checksum_of(const State& state) {
  std::uint64_t sum = 0x46465331;
  const auto take = [&](std::uint64_t word) {
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
    sum ^= sum >> 32;
  };
  const auto number = [&](double value) {
    take(std::isnan(value) ? 0x7ff8000000000000u : value == 0 ? 0 : std::bit_cast<std::uint64_t>(value));
  };
  for (int k = 0; k < 3; ++k) number(state.at[k]);
  for (int k = 0; k < 3; ++k) number(state.force[k]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) number(state.stiffness(r, c));
  for (const double value : {state.energy, state.spacing, state.residual, state.seconds, state.min_jacobian})
    number(value);
  for (int k = 0; k < 3; ++k) number(state.parent[k]);
  for (const char letter : name(state.status)) take(static_cast<unsigned char>(letter));
  take(state.multivalued ? 2 : 1);
  take(static_cast<std::uint64_t>(state.iterations));
  if (state.displacements && !state.displacements->empty()) {
    take(state.displacements->size());
    for (const double value : *state.displacements) take(std::bit_cast<std::uint64_t>(value));
  }
  return static_cast<std::int64_t>(sum);
}

void bind_row(Statement& insert, const State& state) {
  int i = 1;
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.at[k]);
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.force[k]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) insert.bind(i++, state.stiffness(r, c));
  insert.bind(i++, state.energy);
  insert.bind(i++, state.spacing);
  insert.bind(i++, name(state.status));
  insert.bind(i++, state.multivalued ? 1 : 0);
  insert.bind(i++, state.iterations);
  insert.bind(i++, state.residual);
  insert.bind(i++, state.seconds);
  insert.bind(i++, state.min_jacobian);
  for (int k = 0; k < 3; ++k) insert.bind(i++, state.parent[k]);
  if (state.displacements)
    insert.bind_bytes(i, state.displacements->data(), state.displacements->size() * sizeof(double));
  else
    insert.bind_null(i);
  insert.bind(++i, checksum_of(state));
}

bool has_checksums(sqlite3* database, const std::string& where) {
  Statement columns_of(database, where, "SELECT 1 FROM pragma_table_info('states') WHERE name = 'checksum'");
  return columns_of.step();
}

}  // namespace

struct StateFile::Impl {
  std::string where;
  std::unique_ptr<WriterLock> lock;  // released after the database is closed
  Database database;
  StateFileHeader header;
  bool checksums = true;              // whether the table has the column
  std::vector<std::int64_t> damaged;  // ids
};

StateFile::StateFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StateFile::~StateFile() = default;
StateFile::StateFile(StateFile&&) noexcept = default;
StateFile& StateFile::operator=(StateFile&&) noexcept = default;

StateFile StateFile::open_or_create(const fs::path& file, const StateFileHeader& header) {
  check_writable(file);
  auto impl = std::make_unique<Impl>();
  impl->where = file.string();
  std::error_code error;
  if (fs::file_size(file, error) > 0 && !error) check_signature(file);
  impl->lock = std::make_unique<WriterLock>(file);
  if (!fs::exists(file) || fs::file_size(file, error) == 0) create(file, header);
  impl->database = open_database(impl->where, impl->where, SQLITE_OPEN_READWRITE);
  check_schema(impl->database.get(), impl->where);
  impl->header = read_header(impl->database.get(), impl->where);
  check_same_body(impl->where, impl->header.identity, header.identity);
  execute(impl->database.get(), impl->where, "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
  if (!has_checksums(impl->database.get(), impl->where))
    execute(impl->database.get(), impl->where, "ALTER TABLE states ADD COLUMN checksum INTEGER");
  // Labels are measured in the spacing that the states are to fill: the finest that anybody asked for.
  if (header.spacing < impl->header.spacing) {
    execute(impl->database.get(), impl->where,
            fmt::format("UPDATE header SET value = {} WHERE key = 'spacing'", header.spacing).c_str());
    impl->header.spacing = header.spacing;
  }
  return StateFile(std::move(impl));
}

namespace {

// As a plain reader that may tidy up after a killed writer; where the folder cannot be written, without touching it.
Database open_reader(const fs::path& file) {
  const std::string where = file.string();
  const auto attempt = [&](const std::string& name, int flags) {
    Database database = open_database(name, where, flags);
    execute(database.get(), where, "PRAGMA query_only = 1");
    check_schema(database.get(), where);
    return database;
  };
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (::access(folder.c_str(), W_OK) == 0 && ::access(file.c_str(), W_OK) == 0)
    return attempt(where, SQLITE_OPEN_READWRITE);
  if (fs::exists(where + "-wal")) return attempt(where, SQLITE_OPEN_READONLY);
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
  states.reserve(size());
  Statement rows(impl_->database.get(), impl_->where,
                 fmt::format("SELECT {}, {}, id FROM states ORDER BY id", columns,
                             impl_->checksums ? "checksum" : "NULL")
                     .c_str());
  constexpr int checksum = 27, id = 28;  // columns
  impl_->damaged.clear();
  while (rows.step()) {
    if (rows.is_null(checksum)) {  // of a file of before
      states.push_back(read_row(rows, impl_->where));
      continue;
    }
    std::optional<State> state;
    try {
      state = read_row(rows, impl_->where);
    } catch (const InputError&) {  // not even a state any more
    }
    if (state && checksum_of(*state) == rows.integer(checksum))
      states.push_back(*std::move(state));
    else
      impl_->damaged.push_back(rows.integer(id));
  }
  return states;
}

std::string damage_in_words(const std::string& file, std::size_t damaged, bool solved_anew) {
  return fmt::format("{}: {} a wrong checksum: left out{}", file,
                     damaged == 1 ? "1 state has" : fmt::format("{} states have", damaged),
                     solved_anew ? ", to be solved anew" : "");
}

void StateFile::check_pages() const {
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

// All or nothing.
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

void insert_states(sqlite3* database, const std::string& where, std::span<const State> states) {
  Statement insert(
      database, where,
      fmt::format("INSERT INTO states ({}, checksum) VALUES ({})", columns, insert_values).c_str());
  for (const State& state : states) {
    bind_row(insert, state);
    insert.step(), insert.reset();
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

}  // namespace forefeel
