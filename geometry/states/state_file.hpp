#pragma once
// State file (.states): a SQLite database with plain columns, in WAL mode. The body's identity is an opaque
// key -> hash map that the caller fills; a file of another body is refused with the keys that differ.
//
//   identity(key, value)   what the states belong to: mesh, material, clamp, contact
//   header(key, value)     spacing [m], box_low_x … box_high_z [m]
//   notes(key, value)      provenance, free text
//   states(id, x, y, z,                         position of the HIP from rest [m]; id in order of insertion
//          fx, fy, fz,                          force of the body on the HIP [N]
//          k11, k12, … k33,                     stiffness -df_i/dx_j [N/m]
//          energy,                              [J]
//          h,                                   target spacing of an adaptive lattice here [m]
//          status,                              converged, diverged, stalled, inverted, cancelled, measured
//          multivalued, iterations, residual, seconds, min_jacobian, parent_x, parent_y, parent_z,
//          displacements,                       BLOB of #V x 3 doubles [m], NULL unless the scene asks
//          checksum)                            of the values above but id, as state_file.cpp computes it; NULL: not checked
//   Unknown values are NULL. application_id is 0x46465331, user_version 1. Files of before have no column checksum; it is
//   added when they are opened for appending. Who changes a row by other means sets its checksum to NULL.
//
// Durability: synchronous = FULL, so append() returns once the log is flushed to the device. What was appended
// survives a kill of the process, and loss of power as far as the device keeps what it has confirmed. A transaction
// in flight is there whole or not at all.
// Processes: one writer at a time (the second gets an InputError), any number of readers beside it.

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

using BodyIdentity =
    std::map<std::string, std::string>;  // e.g. "mesh" -> "sha256 …", "material", "clamp", "contact"

struct StateFileHeader {
  BodyIdentity identity;
  double spacing = unknown;  // [m]
  Box box;
  std::map<std::string, std::string> notes;  // provenance: scene text, versions; free
};

class StateFile {
 public:
  // Opens for appending; creates where absent. InputError if unreadable, not a state file, or of another body.
  // An empty identity, given or in the file (measured states), agrees with any.
  static StateFile open_or_create(const std::filesystem::path& file, const StateFileHeader& header);
  static StateFile open_read_only(const std::filesystem::path& file);
  ~StateFile();
  StateFile(StateFile&&) noexcept;
  StateFile& operator=(StateFile&&) noexcept;

  const StateFileHeader& header() const;
  // In order of insertion; failed solves included, rows whose checksum is wrong (a damaged disk, another hand) left out.
  std::vector<State> read_all() const;
  void check_pages() const;     // InputError where the database is not well-formed
  std::size_t damaged() const;  // rows that the last read_all() left out
  void drop_damaged();          // takes these out of the file
  std::size_t size() const;
  void append(std::span<const State> states);  // one transaction, durable on return
  void replace(const StateFileHeader& header,
               std::span<const State> states);  // all that it holds, in one transaction

 private:
  struct Impl;
  explicit StateFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A queue in front of a StateFile: push() never blocks on the disk; a thread of its own commits what has waited for
// 20 ms at most, and at destruction. Safe to push from many threads. If the disk fails, the next push() or flush()
// throws the InputError, and nothing more is written.
class StateWriter {
 public:
  explicit StateWriter(StateFile file);
  ~StateWriter();
  StateWriter(StateWriter&&) noexcept;
  StateWriter& operator=(StateWriter&&) noexcept;
  void push(State state);
  void flush();  // returns when all pushed so far is durable

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// CSV with a header line that names the columns, in any order: states x,y,z,fx,fy,fz[,k11,…,k33][,h][,energy], points
// x,y,z. Columns of other names are passed over, but `status` and `converged` are heeded: failed rows stay failed.
// Blank lines and lines that begin with # are skipped. InputError names file and line.
std::vector<State> read_states_csv(const std::filesystem::path& file);
// Usable states only; columns k, h and energy where at least one state has them.
void write_states_csv(const std::filesystem::path& file, std::span<const State> states);
std::vector<Vec3> read_points_csv(const std::filesystem::path& file);
// For ParaView: one vertex a state, with force, stiffness, energy, status and the rest as point data.
void write_states_vtu(const std::filesystem::path& file, std::span<const State> states);

// .states or .csv by content; spacing unknown for a CSV without column h.
struct LoadedStates {
  StateFileHeader header;
  std::vector<State> states;
  std::size_t damaged = 0;  // rows of a .states file left out, see StateFile::read_all()
};
LoadedStates load_states(const std::filesystem::path& file);

// "FILE: 2 states have a wrong checksum: left out", and where they are: ", to be solved anew".
std::string damage_in_words(const std::string& file, std::size_t damaged, bool solved_anew = false);

// InputError naming `where` and what differs, if both identities are known and are not those of one body.
void check_same_body(const std::string& where, const BodyIdentity& in_file, const BodyIdentity& ours);

}  // namespace forefeel
