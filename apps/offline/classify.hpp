#pragma once
// Parts of `forefeel classify`: its options, a set of states prepared for labelling, and its three tasks.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "approx/model/model_options.hpp"
#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "geometry/coverage/octree_index.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/states/check_solves.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {

struct ClassifyInput {
  std::string states, scene;
  std::string known;      // states from before a run
  std::string calibrate;  // a scene
  std::vector<std::string> diff;
  bool foreign = false;  // states of another body beside a scene
};

struct ClassifySpace {
  std::string index = "delaunay", box;
  std::optional<double> spacing;  // [m]
  CoverageOptions coverage;
};

struct ClassifyPlaces {
  std::string points, line, through;
  std::optional<double> grid;            // [m]
  std::optional<std::size_t> snapshots;  // default 40
  bool list = false;                     // print every point
};

struct ClassifyArguments {
  ClassifyInput input;
  ClassifySpace space;
  ClassifyPlaces places;
  bool agreement = false;
  bool bars = false;           // error bars, from forces left out
  KnownNoise noise = {};       // of measured forces, for the bars
  std::string tolerance = {};  // for the error; empty: the scene's, else 7 %
  std::string output, palette = {};
};

// How far places of the box are from the states.
struct Holes {
  double fill_distance = unknown,
         fill_bound = unknown;  // the largest distance as found, and an upper bound [m]
  std::optional<EmptyBall> largest;
};

// Questions about single places need the state space, which takes more memory than the regions.
struct ChosenIndex {
  std::optional<Regions> regions;       // delaunay; octree: for holes and for the agreement
  std::unique_ptr<StateSpace> space;    // delaunay, where it is needed
  std::unique_ptr<OctreeIndex> octree;  // octree
};

// States in the chosen index.
struct Classified {
  std::vector<State> states;  // usable ones, in the order of the file
  // Of states in a plane: their positions a spacing above and below it. A plane has no volume to be known densely; with
  // these, places in it are labelled as between layers.
  std::vector<Vec3> beside;
  std::size_t unusable = 0;
  double spacing = unknown;  // [m]
  int estimated_dimension =
      0;  // of the cloud (3 volume, 2 surface, 1 strokes) if the spacing is estimated; else 0
  // States in a plane fill little of a box unless it lies along the plane: axes of box, leaves and index are turned by
  // this; states and all places told are not.
  Mat3 turn = Mat3::Identity();
  Box box;
  CheckSolves checks;
  ChosenIndex index;
  std::vector<std::array<Vec3, 3>> body;  // triangles of the outline; empty without a scene
  RegionSummary regions;
  Holes holes;
  std::shared_ptr<const AdaptiveLattice> lattice;  // set if the spacing varies from place to place

  std::vector<Vec3> places() const;        // of all states and those beside, turned
  Coverage coverage(const Vec3& q) const;  // delta: to the nearest of the states, not of those beside
  // Of the leaf that contains q, a place of the box, turned.
  Label region_label(const Vec3& q) const {
    return index.octree ? index.octree->label(q) : index.regions->label_at(q);
  }
};

constexpr double largest_spacing = 1e6;  // [m]; larger values may overflow when squared

// Data of a file beside its states: the spacing [m], NaN if unknown; the box, unless it is only the extent of the
// states; and the body.
struct OwnFrame {
  double spacing = unknown;
  std::optional<Box> box = std::nullopt;
  BodyIdentity identity = {};  // known for a state file only
  CheckSolves checks = {};
};
struct StatesInFrame {
  std::vector<State> states;
  OwnFrame own;
};
// A .states file, a CSV, or setup:NAME (setups.hpp).
StatesInFrame load_set(const std::string& file);

// set: of load_set(file).
Classified classify_states(const Globals& globals, const ClassifyArguments& arguments,
                           const std::string& file, StatesInFrame set);
// Spacing, box and outline, without labels. If a box is given, the states may be empty.
Classified prepare_states(const ClassifyArguments& arguments, const std::string& where,
                          std::vector<State> states, const OwnFrame& own, const Globals& globals);
// Labels states in a plane in it, as a layer a quarter of the spacing thick: fills `beside`.
void take_plane(Classified& set, bool have_box, const std::string& where, const Globals& globals);
// Then turns the box so that the plane lies across one of its axes; in the plane the box is the smallest.
void lay_flat(Classified& set);
// What to make beside the regions: holes, the regions' leaves, a state space.
struct LabelWork {
  bool holes = true, leaves = true, space = false;
};
void label_regions(Classified& result, const ClassifyArguments& arguments, const LabelWork& wanted,
                   const Globals& globals);
Holes holes_of(const Regions& regions);

// The JSON keys volume, components, gaps, fill_distance and largest_hole.
struct RegionsShown {
  const RegionSummary& regions;
  const Holes& holes;
};
const JsonKeys<RegionsShown>& region_keys();

int classify_run(const Globals& globals, const ClassifyArguments& arguments);  // writes a .pvd series of RUN/
int classify_diff(const Globals& globals, const ClassifyArguments& arguments);  // --diff A B

// Compares both indexes on the same states and box, by volume. Sampled at the centres of cubes of h/2.
Agreement agreement_of(const Classified& set, const ClassifyArguments& arguments);
const JsonKeys<Agreement>& agreement_keys();
void print_agreement(const Globals& globals, const Agreement& agreement);

nlohmann::ordered_json by_label(const ByLabel<double>& values);
// Volumes by two labels, of rows and of columns [m^3].
using LabelTable = ByLabel<ByLabel<double>>;
nlohmann::ordered_json by_labels(const LabelTable& volume);
void print_volumes(const Globals& globals, const LabelTable& volume, const std::string& columns);
std::int64_t peak_bytes();

}  // namespace forefeel
