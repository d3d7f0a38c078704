#include "solver/lattice/cached_lattice.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/sha256.hpp"
#include "geometry/states/state_file.hpp"
#include "solver/kernels/revision.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

fs::path cache_file(const BodyIdentity& identity, const CachedLatticeOptions& options) {
  if (options.folder.empty()) return {};
  Sha256 hash;
  for (const auto& [key, value] : identity) hash.add(key + "=" + value + "\n");
  hash.add(options.spacing).add(options.tolerance).add(solver_revision());
  return options.folder / (hash.hex().substr(0, 32) + "-lattice.states");
}

// The file of an earlier run, or a new one; nothing if it cannot be used (another process writes to it).
std::optional<StateFile> open_cache(const fs::path& file, const BodyIdentity& identity,
                                    const CachedLatticeOptions& options) {
  if (file.empty()) return {};
  try {
    StateFileHeader header{.identity = identity, .spacing = options.spacing, .box = options.box, .notes = {}};
    header.notes["content"] = "lattice states of experiments";
    return StateFile::open_or_create(file, header);
  } catch (const InputError&) {
    return {};
  }
}

// Keeps the usable states of the box and sorts them.
void tidy(std::vector<State>& states, const CachedLatticeOptions& options) {
  const Vec3 slack = Vec3::Constant(1e-6 * options.spacing);
  const Box wide{options.box.low - slack, options.box.high + slack};
  std::erase_if(states, [&](const State& s) { return !s.usable() || !wide.contains(s.at); });
  std::ranges::sort(states, [](const State& a, const State& b) {
    const double da = a.at.squaredNorm(), db = b.at.squaredNorm();
    return da != db
               ? da < db
               : std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(), b.at.data() + 3);
  });
}

}  // namespace

std::vector<State> cached_lattice_states(const std::shared_ptr<const Body>& body,
                                         const BodyIdentity& identity, const CachedLatticeOptions& options,
                                         const CachedLatticeCalls& calls) {
  const fs::path file = cache_file(identity, options);
  std::optional<StateFile> cache = open_cache(file, identity, options);
  std::vector<State> states;
  if (cache) {
    states = cache->read_all();
    if (cache->damaged() > 0 && calls.damaged)
      calls.damaged(damage_in_words(file.string(), cache->damaged(), true));
    cache->drop_damaged();
  }
  LatticeOptions generate;
  generate.spacing = options.spacing;
  generate.box = options.box;
  generate.threads = options.threads;
  generate.tolerance = options.tolerance;
  const std::vector<State> known = states;
  std::optional<StateWriter> writer;
  if (cache) writer.emplace(std::move(*cache));
  generate_lattice(
      body, generate,
      [&](State state) {
        if (writer) writer->push(state);
        states.push_back(std::move(state));
      },
      [&](std::size_t done, std::size_t total) {
        if (calls.progress) calls.progress(done, total);
      },
      known);
  if (writer) writer->flush();
  tidy(states, options);
  return states;
}

}  // namespace forefeel
