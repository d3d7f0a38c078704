#pragma once
// What `forefeel classify` is made of: its options, a set of states prepared for labelling, and its three tasks.

#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "geometry/coverage/agreement.hpp"
#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

struct ClassifyArguments {
  std::string states, index = "delaunay", box, points, line, output, scene, through, known, calibrate;
  std::vector<std::string> diff;
  std::optional<double> spacing, grid;
  std::optional<std::size_t> snapshots;  // 40 unless said
  bool agreement = false;
  CoverageOptions coverage;
};

// States under the chosen index. The triangulation is built only where it is the index.
struct Classified {
  std::vector<State> states;  // usable ones, in the order of the file
  std::size_t unusable = 0;
  double spacing = unknown;  // [m]
  bool spacing_estimated = false;
  Box box;
  std::unique_ptr<StateSpace> space;      // index delaunay
  std::unique_ptr<OctreeIndex> octree;    // index octree
  std::vector<std::array<Vec3, 3>> body;  // outline, where a scene is given
  RegionSummary regions;
  double fill_distance = unknown,
         fill_bound = unknown;  // largest distance to a state: found, upper bound [m]
  std::optional<LargestHole> hole;
  std::shared_ptr<const AdaptiveLattice> lattice;  // where the states have spacings of their own

  Coverage coverage(const Vec3& q) const { return space ? space->coverage(q) : octree->coverage(q); }
  Label label(const Vec3& q) const { return space ? space->label(q) : octree->label(q); }
};

constexpr double largest_spacing = 1e6;  // [m]; squares of more would overflow somewhere

// What a set of states says of itself: its spacing [m], NaN if unknown; a box, if it is not just the extent
// of the states; the body they belong to.
struct OwnFrame {
  double spacing = unknown;
  std::optional<Box> box = std::nullopt;
  BodyIdentity identity = {};  // of a state file
};
struct StatesInFrame {
  std::vector<State> states;
  OwnFrame own;
};
// A .states file, a CSV, or setup:NAME (setups.hpp).
StatesInFrame load_set(const std::string& file);

Classified classify_states(const Globals& globals, const ClassifyArguments& arguments,
                           const std::string& file);
// Spacing, box and outline without labelling; states may be empty where a box is given.
Classified prepare_states(const ClassifyArguments& arguments, const std::string& where,
                          std::vector<State> states, const OwnFrame& own, const Globals& globals);
// Builds the index (spatially sorted) and the regions.
void label_regions(Classified& result, const ClassifyArguments& arguments, const Globals& globals,
                   bool with_holes);

// Keys volume, components, gaps, fill_distance, largest_hole of the contract.
void regions_json(nlohmann::ordered_json& out, const RegionSummary& regions, double fill_distance,
                  double fill_bound, const std::optional<LargestHole>& hole);

int classify_run(const Globals& globals, const ClassifyArguments& arguments);   // RUN/ to a .pvd series
int classify_diff(const Globals& globals, const ClassifyArguments& arguments);  // --diff A B

// Both indexes over the same states and box, compared by volume at the centres of cubes of h/2.
Agreement agreement_of(const Classified& set, const ClassifyArguments& arguments);
nlohmann::ordered_json agreement_json(const Agreement& agreement);
void print_agreement(const Globals& globals, const Agreement& agreement);

nlohmann::ordered_json by_label(const std::array<double, 4>& values);
std::int64_t peak_bytes();

}  // namespace forefeel
