#pragma once
// State file (.states): SQLite, plain columns, WAL. The body's identity is an opaque key -> hash map that the
// caller fills; a file of another body is refused with the keys that differ. A state appended is on disk within
// 100 ms, and nothing committed is lost by a kill.

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/state.hpp"

namespace forefeel {

using BodyIdentity = std::map<std::string, std::string>;   // e.g. "mesh" -> "sha256 …", "material", "clamp", "contact"

struct StateFileHeader {
  BodyIdentity identity;
  double spacing = unknown;         // [m]
  Box box;
  std::map<std::string, std::string> notes;   // provenance: scene text, versions; free
};

class StateFile {
 public:
  // Opens for appending; creates where absent. InputError if unreadable, not a state file, or of another body
  // (an empty identity accepts any).
  static StateFile open_or_create(const std::filesystem::path& file, const StateFileHeader& header);
  static StateFile open_read_only(const std::filesystem::path& file);
  ~StateFile();
  StateFile(StateFile&&) noexcept;
  StateFile& operator=(StateFile&&) noexcept;

  const StateFileHeader& header() const;
  std::vector<State> read_all() const;                 // in order of insertion; failed solves included
  std::size_t size() const;
  void append(std::span<const State> states);          // one transaction, durable on return
  
 private:
  struct Impl;
  explicit StateFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A queue in front of a StateFile: push() never blocks on the disk; a thread of its own commits every 50 ms and
// at destruction.
class StateWriter {
 public:
  explicit StateWriter(StateFile file);
  ~StateWriter();
  void push(State state);
  void flush();                                        // returns when all pushed so far is durable

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// CSV states x,y,z,fx,fy,fz[,k11,…,k33][,h] with a header line; points x,y,z. InputError names file and line.
std::vector<State> read_states_csv(const std::filesystem::path& file);
void write_states_csv(const std::filesystem::path& file, std::span<const State> states);
std::vector<Vec3> read_points_csv(const std::filesystem::path& file);
// .states or .csv by content; spacing unknown for a CSV without column h.
struct LoadedStates {
  StateFileHeader header;
  std::vector<State> states;
};
LoadedStates load_states(const std::filesystem::path& file);

}  // namespace forefeel
