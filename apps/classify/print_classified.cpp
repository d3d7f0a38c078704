#include "apps/classify/print_classified.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"
#include "apps/console/values.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_gaps = 1000;  // in the document, largest first

nlohmann::ordered_json sides_json(const std::vector<BridgeSide>& sides) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const BridgeSide& side : sides)
    out.push_back({{"direction", vector3(side.direction)},
                   {"half_angle_deg", side.half_angle_deg},
                   {"distance", side.distance},
                   {"states", side.states}});
  return out;
}

// Gaps and the regions that they connect, largest first.
nlohmann::ordered_json gaps_json(const RegionSummary& regions) {
  nlohmann::ordered_json gaps = nlohmann::ordered_json::array();
  for (const RegionComponent& c : regions.components)
    if (c.label == Label::gap && gaps.size() < most_gaps)
      gaps.push_back({{"volume", c.volume},
                      {"inner", vector3(c.inner)},
                      {"safe_components", c.safe_neighbours},
                      {"sides", sides_json(c.sides)}});
  return gaps;
}

}  // namespace

void regions_json(nlohmann::ordered_json& out, const RegionSummary& regions, double fill_distance,
                  double fill_bound, const std::optional<EmptyBall>& hole) {
  out["volume"] = by_label(regions.volume);
  for (int i = 0; i < 4; ++i)
    out["components"][std::string(name(static_cast<Label>(i)))] =
        regions.component_count[static_cast<std::size_t>(i)];
  out["gaps"] = gaps_json(regions);
  out["gaps_left_out"] = regions.component_count[static_cast<std::size_t>(Label::gap)] - out["gaps"].size();
  out["fill_distance"] = number(fill_distance);
  out["fill_distance_bound"] = number(fill_bound);
  if (hole) {
    out["largest_hole"] = {{"radius", hole->radius}, {"centre", vector3(hole->centre)}};
  } else {
    out["largest_hole"] = {{"radius", nullptr},
                           {"centre", nlohmann::ordered_json::array({nullptr, nullptr, nullptr})}};
  }
}

namespace {

nlohmann::ordered_json document_of(const ClassifyArguments& arguments, const ClassifiedPoints& result) {
  const Classified& set = result.set;
  nlohmann::ordered_json out;
  for (const char* key : {"labels", "spread", "alpha", "delta", "gamma_deg"})
    out[key] = nlohmann::ordered_json::array();
  for (const Coverage& c : result.found) {
    out["labels"].push_back(std::string(name(c.label)));
    out["spread"].push_back(number(c.spread));
    out["alpha"].push_back(number(c.alpha));
    out["delta"].push_back(number(c.delta));
    out["gamma_deg"].push_back(number(c.gamma_deg));
  }
  regions_json(out, set.regions, set.fill_distance, set.fill_bound, set.hole);
  out["states"] = set.states.size();
  out["unusable"] = set.unusable;
  out["spacing"] = set.spacing;
  out["spacing_estimated"] = set.spacing_estimated;
  out["box"] = {vector3(set.box.low), vector3(set.box.high)};
  out["index"] = arguments.space.index;
  out["adaptive"] = set.lattice != nullptr;
  if (result.agreement) out["agreement"] = agreement_json(*result.agreement);
  if (result.errors) describe_errors(out, arguments, *result.errors);
  out["leaves"] = set.regions.leaf_count;
  out["seconds"] = result.seconds;
  out["peak_bytes"] = peak_bytes();
  return out;
}

}  // namespace

std::vector<Declared> declared_classified_json() {
  return {{"labels", "", "", "list: safe, sparse, gap or blank of each point"},
          {"spread", "m", "", "list: of each point; null: infinite"},
          {"alpha", "m", "", "list: circumradius; null: infinite"},
          {"delta", "m", "", "list: distance to the nearest state"},
          {"gamma_deg", "degrees", "", "list: half-angle of the largest empty cone; null: not needed"},
          {"volume.LABEL", "m^3", "", "of the box"},
          {"components.LABEL", "", "", "connected regions"},
          {"gaps", "", "", "list, largest first"},
          {"gaps[].volume", "m^3", "", "of one gap region"},
          {"gaps[].inner", "m", "", "a place inside it"},
          {"gaps[].safe_components", "", "", "list: numbers of the safe regions that it touches"},
          {"gaps[].sides", "", "", "list: the sides of the bridge"},
          {"gaps[].sides[].direction", "1", "", "towards known states"},
          {"gaps[].sides[].half_angle_deg", "degrees", "", "of the cone that they fill"},
          {"gaps[].sides[].distance", "m", "", "to the nearest of them"},
          {"gaps[].sides[].states", "", "", "their number"},
          {"gaps_left_out", "", "", "gaps beyond those listed"},
          {"fill_distance", "m", "", "largest distance of a place of the box to its nearest state, as found"},
          {"fill_distance_bound", "m", "", "an upper bound of it"},
          {"largest_hole.radius", "m", "", "of the largest empty ball; null: none"},
          {"largest_hole.centre", "m", "", "its centre"},
          {"states", "", "", "usable"},
          {"unusable", "", "", "failed solves in the file"},
          {"spacing", "m", "", "that counts as dense"},
          {"spacing_estimated", "", "", "true: the median distance of the states, since the file has none"},
          {"box", "m", "", "low and high corner"},
          {"index", "", "", "delaunay or octree"},
          {"adaptive", "", "", "true: the spacing varies from place to place"},
          {"agreement.share", "1", "",
           "with --agreement: share of the volume where both indexes agree, common blank left out"},
          {"agreement.worst", "", "", "with --agreement: labels and volume of the largest disagreement"},
          {"agreement.worst.KEY", "", "", "the same"},
          {"agreement.volume_delaunay_octree.LABEL.LABEL", "m^3", "",
           "with --agreement: by the label of each index"},
          {"leaves", "", "", "of the octree of regions"},
          {"seconds", "s", "", "time to label"},
          {"peak_bytes", "bytes", "", "largest memory of the process"}};
}

namespace {

std::string millimetres(double metres) {
  return std::isnan(metres) ? "-" : fmt::format("{:.4g} mm", 1e3 * metres);
}

constexpr std::size_t most_listed = 20;  // points, unless --list asks for all

void list_points(const std::vector<Vec3>& points, const std::vector<Coverage>& found,
                 const Globals& globals) {
  for (std::size_t i = 0; i < points.size(); ++i)
    answer(globals,
           fmt::format("{:>10.4g} {:>10.4g} {:>10.4g} mm  {:<6}  spread {}  alpha {}  delta {}  gamma {}",
                       1e3 * points[i].x(), 1e3 * points[i].y(), 1e3 * points[i].z(), name(found[i].label),
                       millimetres(found[i].spread), millimetres(found[i].alpha), millimetres(found[i].delta),
                       std::isnan(found[i].gamma_deg) ? "not needed"
                                                      : fmt::format("{:.4g} deg", found[i].gamma_deg)));
}

// "1331 points: safe 343, sparse 386, gap 0, blank 602; --list prints each"
void count_points(const std::vector<Coverage>& found, const Globals& globals) {
  std::array<std::size_t, 4> count{};
  for (const Coverage& c : found) ++count[static_cast<std::size_t>(c.label)];
  std::string text;
  for (std::size_t k = 0; k < count.size(); ++k)
    text += fmt::format("{} {} {}", k == 0 ? ":" : ",", name(static_cast<Label>(k)), count[k]);
  answer(globals, fmt::format("{} points{}; --list prints each", found.size(), text));
}

void print_summary(const Classified& set, double seconds, const Globals& globals) {
  int gaps = 0;
  double all = 0;
  for (const double v : set.regions.volume) all += v;
  answer(globals, fmt::format("{} states, h = {:.4g} mm{}{}", set.states.size(), 1e3 * set.spacing,
                              set.spacing_estimated ? " (estimated)"
                              : set.lattice         ? " at the finest"
                                                    : "",
                              set.unusable ? fmt::format(", {} failed ones left out", set.unusable) : ""));
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    answer(globals,
           fmt::format("{:<7}{:>12.5g} cm3 {:>6.1f} %  {} component{}", name(static_cast<Label>(i)),
                       1e6 * set.regions.volume[k], all > 0 ? 100 * set.regions.volume[k] / all : 0.0,
                       set.regions.component_count[k], set.regions.component_count[k] == 1 ? "" : "s"));
  }
  for (const RegionComponent& c : set.regions.components)
    if (c.label == Label::gap && ++gaps <= 5)
      say(globals,
          fmt::format(
              "gap of {:.4g} cm3 around {:.4g}, {:.4g}, {:.4g} mm: {} side{}, beside {} safe component{}",
              1e6 * c.volume, 1e3 * c.inner.x(), 1e3 * c.inner.y(), 1e3 * c.inner.z(), c.sides.size(),
              c.sides.size() == 1 ? "" : "s", c.safe_neighbours.size(),
              c.safe_neighbours.size() == 1 ? "" : "s"));
  answer(globals, fmt::format("fill distance {:.4g} mm{}", 1e3 * set.fill_distance,
                              set.fill_bound > set.fill_distance + 1.001e-3 * set.spacing
                                  ? fmt::format(", at most {:.4g} mm", 1e3 * set.fill_bound)
                                  : ""));
  if (set.hole)
    answer(globals,
           fmt::format("largest hole {:.4g} mm at {:.4g}, {:.4g}, {:.4g} mm", 1e3 * set.hole->radius,
                       1e3 * set.hole->centre.x(), 1e3 * set.hole->centre.y(), 1e3 * set.hole->centre.z()));
  say(globals, fmt::format("{:.3g} s, {:.0f} MB at most", seconds, 1e-6 * double(peak_bytes())));
}

}  // namespace

void print_classified(const Globals& globals, const ClassifyArguments& arguments,
                      const ClassifiedPoints& result) {
  if (globals.json) return print_json(document_of(arguments, result));
  const std::string extension = std::filesystem::path(arguments.output).extension();
  if (arguments.places.list || (result.points.size() <= most_listed && extension != ".csv"))
    list_points(result.points, result.found, globals);
  else if (!result.points.empty())
    count_points(result.found, globals);
  print_summary(result.set, result.seconds, globals);
  if (result.errors) tell_errors(globals, arguments, *result.errors);
  if (!arguments.output.empty() && extension != ".vtu")  // a .vtu names its three files itself
    say(globals, fmt::format("{}: {}",
                             extension != ".csv"     ? "picture"
                             : result.points.empty() ? "regions"
                                                     : "labels of the points",
                             arguments.output));
  if (result.agreement) print_agreement(globals, *result.agreement);
}

std::vector<Declared> declared_coverage() {
  return {{"x,y,z", "m", "", "position"},
          {"label", "", "", "safe, sparse, gap or blank"},
          {"spread", "m", "",
           "sqrt(R^2 - d^2) in its Delaunay cell: R circumradius, d distance to the circumcentre"},
          {"alpha", "m", "", "circumradius of the cell, the least where several touch"},
          {"delta", "m", "", "distance to the nearest state"},
          {"gamma_deg", "degrees", "",
           "half-angle of the largest empty cone of directions to states within 8 h"}};
}

}  // namespace forefeel
