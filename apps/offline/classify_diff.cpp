// forefeel classify --diff A B: which labels differ between two sets of states, by volume.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/offline/classify.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_file.hpp"
#include "geometry/coverage/regions.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

// The result of `forefeel classify --diff A B`.
struct DiffResult {
  std::array<Classified, 2> set;
  double spacing = unknown;  // of both
  LabelTable volume{};       // rows: label in A, columns: in B [m^3]
  std::vector<RegionChange> changed;
  double seconds = 0;

  // Volume whose label changed, and the part of it whose label improved [m^3].
  double moved() const {
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b)
        if (a != b) sum += volume[a][b];
    return sum;
  }
  double better() const {
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b) sum += volume[a][b];
    return sum;
  }
};

// One spacing and one box for both sets; otherwise their volumes could not be compared.
Classified common_frame(const Globals& globals, const ClassifyArguments& arguments,
                        const std::array<StatesInFrame, 2>& loaded) {
  OwnFrame own = loaded[0].own;
  const double other = loaded[1].own.spacing;
  if (!arguments.space.spacing && arguments.input.scene.empty() && std::isfinite(own.spacing) &&
      std::isfinite(other) && std::abs(other - own.spacing) > 1e-9 * own.spacing)
    throw InputError(
        "--diff",
        fmt::format("{} has a spacing of {:.4g} m and {} one of {:.4g} m, expected --spacing for both",
                    arguments.input.diff[0], own.spacing, arguments.input.diff[1], other));
  check_same_body(arguments.input.diff[1], loaded[1].own.identity, own.identity);
  if (own.box && loaded[1].own.box)
    own.box =
        Box{own.box->low.cwiseMin(loaded[1].own.box->low), own.box->high.cwiseMax(loaded[1].own.box->high)};
  std::vector<State> both = loaded[0].states;
  both.insert(both.end(), loaded[1].states.begin(), loaded[1].states.end());
  return prepare_states(arguments, arguments.input.diff[0], std::move(both), own, globals);
}

// Compares voxels of h/4 inside the leaves of B, because a leaf of B may contain several of A.
void compare(DiffResult& result) {
  const auto label_in_a = [&](const Vec3& q) { return result.set[0].region_label(q); };
  const double side = result.spacing / 4;
  for (const RegionLeaf& leaf : result.set[1].regions.leaves) {
    const Vec3 size = leaf.box.size();
    std::array<int, 3> n{};
    for (unsigned axis = 0; axis < 3; ++axis)
      n[axis] = std::max(1, static_cast<int>(std::lround(size[axis] / side)));
    const Vec3 step = size.cwiseQuotient(Vec3(n[0], n[1], n[2]));
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          const Vec3 low = leaf.box.low + step.cwiseProduct(Vec3(i, j, k));
          const Label before = label_in_a(low + 0.5 * step);
          result.volume[before][leaf.label] += step.prod();
          if (before != leaf.label) result.changed.push_back({{low, low + step}, before, leaf.label});
        }
  }
}

void write_changes_csv(const std::string& file, const std::vector<RegionChange>& changed) {
  OutputFile out(file);
  out.write("x,y,z,dx,dy,dz,before,after\n");
  for (const RegionChange& leaf : changed) {
    const Vec3 c = leaf.box.centre(), d = leaf.box.size();
    out.write(fmt::format("{},{},{},{},{},{},{},{}\n", c.x(), c.y(), c.z(), d.x(), d.y(), d.z(),
                          name(leaf.before), name(leaf.after)));
  }
  out.commit();
}

DiffResult make_diff(const Globals& globals, const ClassifyArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  std::array<StatesInFrame, 2> loaded{load_set(arguments.input.diff[0]), load_set(arguments.input.diff[1])};
  const Classified frame = common_frame(globals, arguments, loaded);
  ClassifyArguments common = arguments;
  common.space.spacing = frame.spacing;
  common.space.box.clear();
  common.input.scene.clear();
  DiffResult result;
  result.spacing = frame.spacing;
  for (std::size_t i = 0; i < 2; ++i) {
    result.set[i] = prepare_states(common, arguments.input.diff[i], std::move(loaded[i].states),
                                   {frame.spacing, frame.box}, globals);
    label_regions(result.set[i], common, {.holes = i == 1, .leaves = i == 1}, globals);
  }
  compare(result);
  if (arguments.output.ends_with(".vtu")) write_changes_vtu(arguments.output, result.changed);
  if (arguments.output.ends_with(".csv")) write_changes_csv(arguments.output, result.changed);
  result.seconds = seconds_since(start);
  return result;
}

nlohmann::ordered_json to_json(const DiffResult& result) {
  const double moved = result.moved(), better = result.better();
  const Classified& b = result.set[1];
  nlohmann::ordered_json out{{"diff",
                              {{"from_to", by_labels(result.volume)},
                               {"changed", moved},
                               {"better", better},
                               {"worse", moved - better}}},
                             {"states", {result.set[0].states.size(), b.states.size()}},
                             {"spacing", result.spacing}};
  add_to(out, region_keys(), {b.regions, b.holes});
  out["seconds"] = result.seconds;
  out["peak_bytes"] = peak_bytes();
  return out;
}

void tell(const Globals& globals, const DiffResult& result) {
  say(globals, fmt::format("h = {:.4g} mm", 1e3 * result.spacing));
  print_volumes(globals, result.volume, "in B");
  say(globals, fmt::format("changed {:.4g} cm3, {:.4g} of it for the better", 1e6 * result.moved(),
                           1e6 * result.better()));
}

}  // namespace

int classify_diff(const Globals& globals, const ClassifyArguments& arguments) {
  const DiffResult result = make_diff(globals, arguments);
  if (globals.json)
    print_json(to_json(result));
  else
    tell(globals, result);
  return 0;
}

}  // namespace forefeel
