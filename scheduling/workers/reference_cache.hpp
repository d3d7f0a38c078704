#pragma once
// The file that keeps the reference solves of a body: a state file named after the body's identity, the continuation
// step and the revision of the solver. One thread at a time.

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/types.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

class RestSites;
struct Body;

struct ReferenceOptions {
  std::shared_ptr<const Body> body;
  BodyIdentity identity;                        // key of the cache; empty: no cache
  double spacing = 0.006;                       // continuation step of the reference branch [m]
  Box box;                                      // recorded_costs() draws its positions here [m]
  bool displacements = false;                   // states hold them
  int jet = 1;                                  // order of the force that states keep
  std::shared_ptr<const RestSites> sites = {};  // of a body that is touched anywhere: places have a site
  std::filesystem::path cache_folder;           // empty: no cache
};

class ReferenceCache {
 public:
  // names_only: no file, because solves cost less than reading one.
  ReferenceCache(const ReferenceOptions& options, bool names_only);

  const std::string& name() const { return name_; }  // of the body's files; empty: no cache
  std::vector<State> take_states() { return std::exchange(states_, {}); }  // of the file when it was opened
  void keep(const State& state);

  // If a cache was requested: why there is none, or why it is read-only.
  const std::optional<std::string>& note() const { return note_; }
  // Set if records had a wrong checksum: one line with file and count.
  const std::optional<std::string>& damage() const { return damage_; }
  // Waits until all is on the disk. One line if it could no longer be written; nothing is kept after that.
  std::optional<std::string> failure();

 private:
  void read(const StateFile& file, const std::filesystem::path& path);
  void fail(const std::exception& problem);

  std::string name_;
  std::vector<State> states_;
  std::unique_ptr<StateWriter> writer_;
  bool unflushed_ = false;  // states were given to the writer
  std::optional<std::string> note_, damage_, failure_;
};

}  // namespace forefeel
