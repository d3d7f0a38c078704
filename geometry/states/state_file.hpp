#pragma once
// State file (.states): a SQLite database with plain columns, in WAL mode. The identity of the body is a map
// from keys to hashes that the caller fills; a file of another body is refused, and the error names the keys
// that differ.
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
//          checksum,                            of all values but id (state_rows.cpp); NULL: not checked
//          e300, e210, … e005, limit,           the state's energy jet (energy_jet.hpp) and its material limit [m];
//                                               coefficients above the jet's order NULL, limit may be infinite
//          sx, sy, sz)                          site of a pad anywhere, on the rest surface [m]; all NULL: none
//   Unknown values are NULL. application_id is 0x46465331, user_version 1. Older files have no column
//   checksum; it is added when they are opened for appending. The columns of jets, and
//   those of sites, are added with the first state that has one. If you edit a row with another tool, set its checksum
//   to NULL.
//
// Durability: synchronous = FULL. When append() returns, the log is on the device. Appended states survive the end
// of the process. They survive a power failure if the device keeps what it has confirmed. A transaction is stored
// completely or not at all.
// Processes: one writer at a time, the second gets an InputError; any number of readers beside it.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "geometry/states/state_header.hpp"

namespace forefeel {

struct Declared;

class StateFile {
 public:
  // Opens for appending; creates the file if it is missing. InputError: unreadable, no state file, or of another body.
  // A file has either states of a body with an identity, or states without one (measured). A header of the other kind
  // is refused.
  static StateFile open_or_create(const std::filesystem::path& file, const StateFileHeader& header);
  static StateFile open_read_only(const std::filesystem::path& file);
  ~StateFile();
  StateFile(StateFile&&) noexcept;
  StateFile& operator=(StateFile&&) noexcept;

  const StateFileHeader& header() const;
  // In order of insertion, failed solves included. Rows with a wrong checksum (a damaged disk, a foreign
  // edit) are left out and counted by damaged().
  std::vector<State> read_all() const;
  void check_pages() const;     // InputError where the database is not well-formed
  std::size_t damaged() const;  // rows that the last read_all() left out
  void drop_damaged();          // deletes these rows
  std::size_t size() const;
  void append(std::span<const State> states);  // one transaction, durable on return
  // Orders the states by their distance from rest, then by x, y, z: workers add them as they are solved.
  void order_outward();
  // Replaces header and states in one transaction.
  void replace(const StateFileHeader& header, std::span<const State> states);

 private:
  struct Impl;
  explicit StateFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A queue in front of a StateFile. push() never waits for the disk and may be called by many threads. A background
// thread commits states at most 20 ms after push(); the destructor commits the rest. If the disk fails, the next
// push() or flush() throws the InputError, and nothing more is written.
class StateWriter {
 public:
  explicit StateWriter(StateFile file);
  ~StateWriter();
  StateWriter(StateWriter&&) noexcept;
  StateWriter& operator=(StateWriter&&) noexcept;
  void push(State state);
  void flush();                 // returns when all pushed so far is durable
  std::size_t written() const;  // how many of the pushed states are durable, in the order of push()

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// CSV with a header line that names the columns, in any order: states
// [sx,sy,sz,]x,y,z,fx,fy,fz[,k11,…,k33][,h][,energy][,e300,…,e005,limit]; points [sx,sy,sz,]x,y,z. Coefficients of
// jets are there up to a whole degree. Other columns are ignored, except `status` and
// `converged`, which mark failed solves. Blank lines and lines that begin with # are skipped. InputError
// names file and line.
std::vector<State> read_states_csv(const std::filesystem::path& file);

// What a table tells of each place: nothing more (forces NaN), one value, read as the force (value, 0, 0), or a force.
enum class Tells : std::uint8_t { places, value, force };
inline constexpr const char* tells_note = "tells";  // in the notes of a state file: "places" or "value"
inline constexpr const char* value_note = "value";  // in the notes: name of the value
struct StateTable {
  std::vector<State> states;
  Tells tells = Tells::force;
  std::string value = {};  // name of the column of values
};
// Also x,y,z alone or with one more column, and both without a header line.
StateTable read_table_csv(const std::filesystem::path& file);

// Only usable states. Columns k, h, energy and those of jets are written if at least one state has them.
void write_states_csv(const std::filesystem::path& file, std::span<const State> states);
std::vector<Declared> declared_states();  // all these columns, for `forefeel help`
std::vector<Vec3> read_points_csv(const std::filesystem::path& file);
// With sites; InputError if the file has no columns sx,sy,sz.
struct SitedPoint {
  Vec3 site, at;
};
std::vector<SitedPoint> read_sited_points_csv(const std::filesystem::path& file);
// For ParaView: one vertex for each state, with force, stiffness, energy, status and the rest as point data.
void write_states_vtu(const std::filesystem::path& file, std::span<const State> states);

// A .states or .csv file; the content decides which. The spacing of a CSV without column h is unknown.
struct LoadedStates {
  StateFileHeader header;
  std::vector<State> states;
  std::size_t damaged = 0;  // rows of a .states file left out, see StateFile::read_all()
  Tells tells = Tells::force;
  std::string value = {};  // name of what is known at each place
};
// InputError where the file tells less than `least`.
LoadedStates load_states(const std::filesystem::path& file, Tells least = Tells::force);

// "FILE: 2 states have a wrong checksum: left out", with ", to be solved anew" if they will be.
std::string damage_in_words(const std::string& file, std::size_t damaged, bool solved_anew = false);

}  // namespace forefeel
