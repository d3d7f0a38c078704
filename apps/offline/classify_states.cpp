// States prepared for labelling: spacing, box, index, regions.

#include <fmt/format.h>
#include <omp.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "apps/offline/classify.hpp"
#include "apps/offline/hull_spacing.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/coverage/voxels.hpp"
#include "geometry/index/morton_order.hpp"
#include "geometry/states/check_solves.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/state_file.hpp"
#include "solver/body/body.hpp"

namespace forefeel {
namespace {

Box parse_box(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos)
    throw InputError("--box", fmt::format("'{}' is not a box, expected X0,Y0,Z0:X1,Y1,Z1", text));
  const Box box{parse_vector(text.substr(0, colon), "--box"), parse_vector(text.substr(colon + 1), "--box")};
  if ((box.low.array() > box.high.array()).any())
    throw InputError("--box",
                     fmt::format("'{}' has its first corner above its second, expected low:high", text));
  if (!(box.size().prod() > 0))
    throw InputError("--box", fmt::format("'{}' has no volume, expected low below high on every axis", text));
  return box;
}

void take_scene(const ClassifyArguments& arguments, const std::string& where, const OwnFrame& own,
                const Globals& globals, Classified& result) {
  const bool needed = !std::isfinite(result.spacing);
  const Scene scene =
      load_scene(arguments.input.scene, globals.set, nullptr, {.spacing = needed, .quiet = globals.quiet});
  belonging_of(globals, scene, where, own.identity, result.states, arguments.input.foreign);
  if (needed) result.spacing = scene.space.spacing;
  result.box = scene.space.box;
  // HIP coordinates are relative to the rest position of the contact.
  const Vec3 contact = rest_of_contact(*scene.body);
  for (const Triangle& t : boundary_triangles(scene.body->mesh)) {
    std::array<Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = scene.body->mesh.nodes[t[i]] - contact;
    result.body.push_back(corners);
  }
}

// Of an estimated spacing, as along strokes far apart: one that the hull of the states can have.
std::string wider_spacing(const Classified& set, const CoverageOptions& coverage) {
  if (set.estimated_dimension == 0) return {};
  const double spacing = hull_spacing(set.places(), set.box, coverage).spacing;
  return spacing > set.spacing ? fmt::format(": {:.2g} would make about 90 % of their hull safe", spacing)
                               : std::string();
}

// Regions consist of cubes of h/4. A box with too many cubes is refused before memory is allocated.
void check_extent(const Classified& set, const CoverageOptions& coverage, const std::string& where) {
  double voxels = 1, points = 0;
  for (int axis = 0; axis < 3; ++axis) {
    voxels *= std::max(1.0, 4 * set.box.size()[axis] / set.spacing);
    points = std::max({points, std::abs(set.box.low[axis]), std::abs(set.box.high[axis])});
  }
  if (!(voxels <= 1e9))
    throw InputError(
        where,
        fmt::format("its box of {:.3g} x {:.3g} x {:.3g} m holds {:.2g} cubes of a quarter of the spacing "
                    "({:.3g} m), expected at most 1e9: a smaller --box or a larger --spacing{}",
                    set.box.size().x(), set.box.size().y(), set.box.size().z(), voxels, set.spacing,
                    wider_spacing(set, coverage)));
  // States closer than 1e-9 h count as one, so doubles must resolve that distance.
  if (!(points <= 1e6 * set.spacing))
    throw InputError(
        where,
        fmt::format("it lies up to {:.3g} m from rest, too far to tell states at a spacing of {:.3g} m "
                    "apart exactly, expected at most a million spacings",
                    points, set.spacing));
}

bool has_points(const ClassifyArguments& arguments) {
  return !arguments.places.points.empty() || !arguments.places.line.empty() ||
         arguments.places.grid.has_value();
}

LabelWork work_of(const ClassifyArguments& arguments) {
  const bool vtu = arguments.output.ends_with(".vtu"), points = has_points(arguments);
  return {.holes = true,
          .leaves = vtu || (arguments.output.ends_with(".csv") && !points),
          .space = points || vtu};
}

// Memory of a classification (measured): for each state its values, twice as much while a file is read, and for each
// voxel its label and a share of the runs of equal labels.
double bytes_needed(const Classified& set, const ClassifyArguments& arguments, const LabelWork& wanted) {
  const auto states = static_cast<double>(set.states.size());
  const VoxelGrid grid(set.box, set.spacing / 4);
  const double voxels = grid.count[0] * grid.count[1] * grid.count[2];
  double bytes = 400 * states;
  const bool delaunay = arguments.space.index == "delaunay";
  if (delaunay) bytes += 4 * voxels + std::min(states, 9e4) * 1e3 * omp_get_max_threads();
  if (delaunay ? wanted.space : true) bytes += 900 * states;
  if (wanted.leaves) bytes += 30 * voxels;
  return bytes;
}

void check_memory(const Classified& set, const ClassifyArguments& arguments, const LabelWork& wanted,
                  const std::string& where, const Globals& globals) {
  const std::size_t states = set.states.size();
  const double bytes = bytes_needed(set, arguments, wanted), left = available_memory();
  if (bytes > left)
    throw InputError(
        where, fmt::format("the coverage of its {} states needs about {}, expected fewer states, a larger "
                           "spacing or more memory: {} are left",
                           states, bytes_in_words(bytes), bytes_in_words(left)));
  if (states >= 1'000'000)
    say(globals, fmt::format("{} states: about {} of memory, {} are left", states, bytes_in_words(bytes),
                             bytes_in_words(left)));
}

std::unique_ptr<OctreeIndex> make_octree(const Classified& set, const ClassifyArguments& arguments) {
  auto octree = set.lattice
                    ? std::make_unique<OctreeIndex>(AdaptiveLattice(*set.lattice), arguments.space.coverage)
                    : std::make_unique<OctreeIndex>(set.spacing, arguments.space.coverage);
  const std::vector<Vec3> places = set.places();
  for (std::uint32_t i = 0; i < places.size(); ++i) octree->insert({i}, places[i]);
  return octree;
}

// The states for the triangulation, without displacements.
std::unique_ptr<StateSpace> make_space(const Classified& set, const ClassifyArguments& arguments,
                                       const std::function<void(double)>& progress) {
  auto space = std::make_unique<StateSpace>(StateSpaceOptions{
      .spacing = set.spacing, .box = set.box, .coverage = arguments.space.coverage, .lattice = set.lattice});
  const std::vector<Vec3> places = set.places();
  std::size_t done = 0;
  for (const std::uint32_t i : morton_order(places, set.box, set.spacing)) {
    State state;
    state.at = places[i];
    space->insert(std::move(state));
    if (++done % 1024 == 0) progress(double(done) / double(places.size()));
  }
  return space;
}

Regions make_regions(const Classified& set, const ClassifyArguments& arguments,
                     const std::function<void(double)>& progress) {
  return Regions(
      set.places(),
      {.spacing = set.spacing, .box = set.box, .coverage = arguments.space.coverage, .lattice = set.lattice},
      progress);
}

void label_octree(Classified& result, const ClassifyArguments& arguments) {
  result.index.octree = make_octree(result, arguments);
  const double rim = rim_reach(arguments.space.coverage.sparse_distance,
                               result.lattice ? result.lattice->coarsest() : result.spacing);
  result.regions = sample_regions(result.box, result.spacing, rim, [&](const Vec3& q) {
    thread_local PathWalk walk;  // along the rows of voxels
    return result.index.octree->label(q, walk);
  });
  const CoverageOptions& coverage = arguments.space.coverage;
  find_sides(result.regions.components, coverage.sparse_distance,
             [&](const Vec3& place, std::vector<Vec3>& offsets) {
               const double h = result.lattice ? result.lattice->spacing_at(place) : result.spacing;
               result.index.octree->points().offsets_within(place, coverage.gap_cone_radius * h, offsets);
             });
}

}  // namespace

Agreement agreement_of(const Classified& set, const ClassifyArguments& arguments) {
  std::unique_ptr<OctreeIndex> octree;
  if (!set.index.octree) octree = make_octree(set, arguments);
  return compare_indexes(*set.index.regions, set.index.octree ? *set.index.octree : *octree);
}

const JsonKeys<Agreement>& agreement_keys() {
  using A = Agreement;
  static const JsonKeys<A> keys{
      {"agreement.share", "1",
       "with --agreement: share of the volume where both indexes agree, common blank left out", &A::share},
      {"agreement.volume_delaunay_octree.LABEL.LABEL", "m^3", "with --agreement: by the label of each index",
       [](const A& a) { return by_labels(a.volume); }},
      {"agreement.worst", "", "with --agreement: labels and volume of the largest disagreement",
       [](const A& a) {
         if (!a.worst) return Json();
         return Json{{"at", vector3(a.worst->at)},
                     {"delaunay", std::string(name(a.worst->delaunay))},
                     {"octree", std::string(name(a.worst->octree))}};
       }},
      {"agreement.worst.KEY", "", "the same"}};
  return keys;
}

void print_agreement(const Globals& globals, const Agreement& agreement) {
  say(globals, fmt::format("the indexes agree on {:.2f} % of the volume, common blank left out",
                           100 * agreement.share));
  print_volumes(globals, agreement.volume, "octree");
  if (const auto& worst = agreement.worst)
    say(globals, fmt::format("in the middle of the longest stretch that differs along x: {:.4g}, {:.4g}, "
                             "{:.4g} mm, {} against {}",
                             1e3 * worst->at.x(), 1e3 * worst->at.y(), 1e3 * worst->at.z(),
                             name(worst->delaunay), name(worst->octree)));
}

Classified prepare_states(const ClassifyArguments& arguments, const std::string& where,
                          std::vector<State> states, const OwnFrame& own, const Globals& globals) {
  Classified result;
  const std::size_t all = states.size();
  std::erase_if(states, [](const State& s) { return !s.usable() || !s.at.allFinite(); });
  result.unusable = all - states.size();
  result.states = std::move(states);
  result.checks = own.checks;
  result.spacing = arguments.space.spacing.value_or(unknown);
  bool have_box = !arguments.space.box.empty();
  if (!arguments.input.scene.empty()) {
    take_scene(arguments, where, own, globals, result);
    have_box = true;
  }
  if (!std::isfinite(result.spacing)) result.spacing = own.spacing;
  const bool own_spacings = !std::isfinite(result.spacing) || !arguments.space.spacing;
  if (!std::isfinite(result.spacing))
    for (const State& s : result.states)
      if (std::isfinite(s.spacing) && !(s.spacing <= result.spacing)) result.spacing = s.spacing;
  if (!std::isfinite(result.spacing)) {
    const EstimatedSpacing estimated = estimated_spacing(result.states);
    result.spacing = estimated.spacing;
    result.estimated_dimension = estimated.dimension;
  }
  if (!(result.spacing > 0))
    throw InputError(where,
                     "gives no spacing and has too few states to estimate one, expected --spacing METRES");
  if (!(result.spacing <= largest_spacing))
    throw InputError(where, fmt::format("has a spacing of {:.3g} m, expected at most {:.0e} m",
                                        result.spacing, largest_spacing));
  if (!arguments.space.box.empty()) result.box = parse_box(arguments.space.box);
  if (!have_box && own.box) {
    result.box = *own.box;
  } else if (!have_box) {
    if (result.states.empty()) throw InputError(where, "holds no usable state, expected states or --box");
    result.box = {result.states[0].at, result.states[0].at};
    for (const State& s : result.states)
      result.box = {result.box.low.cwiseMin(s.at), result.box.high.cwiseMax(s.at)};
  }
  if (own_spacings)
    if (std::optional<AdaptiveLattice> lattice = lattice_of(result.states, result.box)) {
      result.lattice = std::make_shared<const AdaptiveLattice>(std::move(*lattice));
      for (const State& s : result.states)
        if (s.spacing < result.spacing) result.spacing = s.spacing;
    }
  take_plane(result, have_box || own.box, where, globals);
  check_extent(result, arguments.space.coverage, where);
  return result;
}

// Fill distance and largest hole depend on states and box, not on the index.
Holes holes_of(const Regions& regions) {
  const double fill = regions.fill_distance();
  return {.fill_distance = fill,
          .fill_bound = fill + 1e-3 * regions.options().spacing,
          .largest = regions.largest_hole()};
}

void label_regions(Classified& result, const ClassifyArguments& arguments, const LabelWork& wanted,
                   const Globals& globals) {
  Progress progress(globals, "classify");
  progress.show(0, "index");
  const bool octree = arguments.space.index == "octree";
  if (octree) label_octree(result, arguments);
  if (!octree || wanted.holes)
    result.index.regions =
        make_regions(result, arguments, [&](double share) { progress.show(0.8 * share, "regions"); });
  progress.show(0.8, "components and holes");
  if (!octree) result.regions = result.index.regions->summary(wanted.leaves);
  if (wanted.holes) result.holes = holes_of(*result.index.regions);
  const Mat3 back = result.turn.transpose();
  for (RegionComponent& component : result.regions.components) {
    component.inner = back * component.inner;
    for (BridgeSide& side : component.sides) side.direction = back * side.direction;
  }
  if (result.holes.largest) result.holes.largest->centre = back * result.holes.largest->centre;
  if (!octree && wanted.space)
    result.index.space =
        make_space(result, arguments, [&](double share) { progress.show(0.8 + 0.2 * share, "states"); });
}

StatesInFrame load_set(const std::string& file) {
  StatesInFrame set;
  if (!file.starts_with("setup:")) {
    LoadedStates loaded = load_states(file, Tells::places);
    if (loaded.damaged > 0) warn({}, damage_in_words(file, loaded.damaged));
    if (loaded.header.identity.empty() && loaded.tells == Tells::force)
      for (const std::string& line : misleading(loaded.states, loaded.header.spacing))
        warn({}, fmt::format("{}: {}", file, line));
    set.states = std::move(loaded.states);
    set.own = {loaded.header.spacing, std::nullopt, loaded.header.identity, check_solves(loaded.header)};
    return set;
  }
  const SetupOptions options;
  const Setup setup = make_setup(file.substr(6), options);
  for (const Vec3& at : setup.states) {
    State state;
    state.at = at;
    set.states.push_back(std::move(state));
  }
  set.own = {options.spacing, setup.box, {}};
  return set;
}

Classified classify_states(const Globals& globals, const ClassifyArguments& arguments,
                           const std::string& file, StatesInFrame set) {
  Classified result = prepare_states(arguments, file, std::move(set.states), set.own, globals);
  if (!result.beside.empty() && arguments.space.box.empty() && arguments.input.scene.empty() && !set.own.box)
    lay_flat(result);
  const LabelWork wanted = work_of(arguments);
  check_memory(result, arguments, wanted, file, globals);
  label_regions(result, arguments, wanted, globals);
  return result;
}

nlohmann::ordered_json by_label(const ByLabel<double>& values) {
  nlohmann::ordered_json result;
  for (const Label label : all_labels) result[std::string(name(label))] = number(values[label]);
  return result;
}

nlohmann::ordered_json by_labels(const LabelTable& volume) {
  nlohmann::ordered_json table;
  for (const Label row : all_labels) table[std::string(name(row))] = by_label(volume[row]);
  return table;
}

void print_volumes(const Globals& globals, const LabelTable& volume, const std::string& columns) {
  say(globals, "volume [cm3]  safe       sparse     gap        blank      (" + columns + ")");
  for (const Label row : all_labels) {
    const ByLabel<double>& v = volume[row];
    say(globals, fmt::format("{:<12}{:>10.4g} {:>10.4g} {:>10.4g} {:>10.4g}", name(row), 1e6 * v[0],
                             1e6 * v[1], 1e6 * v[2], 1e6 * v[3]));
  }
}

std::int64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace forefeel
