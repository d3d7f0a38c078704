#pragma once
// The states of the lattice {k h}^3 in a box, solved at most once: a state file in a cache folder keeps them from run
// to run. The name of the file is a hash of the body's identity, h, the tolerance and the revision of the solver.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"
#include "geometry/states/state_header.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct CachedLatticeOptions {
  double spacing = 0.006;             // h [m]
  Box box;                            // [m]
  int threads = 0;                    // 0: all
  double tolerance = 1e-9;            // of the force, relative
  std::filesystem::path folder = {};  // of the cache; empty: nothing is kept
};

struct CachedLatticeCalls {
  std::function<void(std::size_t done, std::size_t total)> progress = {};
  std::function<void(const std::string& message)> damaged = {};  // rows of the file that must be solved again
};

// Returns the usable states in the box (and within 1e-6 h of it), by increasing distance from rest, ties by (x, y,
// z). An interrupted run keeps the states it has solved, and the next run solves the rest. If the file is in use or
// unreadable, all states are solved again and nothing is kept.
std::vector<State> cached_lattice_states(const std::shared_ptr<const Body>& body,
                                         const BodyIdentity& identity, const CachedLatticeOptions& options,
                                         const CachedLatticeCalls& calls = {});

}  // namespace forefeel
