#include "apps/offline/print_classified.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/units.hpp"
#include "apps/console/values.hpp"
#include "geometry/common/counted.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_gaps = 1000;  // in the document, largest first

JsonKeys<BridgeSide> side_keys() {
  using S = BridgeSide;
  return {{"direction", "1", "towards known states", &S::direction},
          {"half_angle_deg", "degrees", "of the cone that they fill", &S::half_angle_deg},
          {"distance", "m", "to the nearest of them", &S::distance},
          {"states", "", "their number", &S::states}};
}

JsonKeys<RegionComponent> gap_keys() {
  using C = RegionComponent;
  return {{"volume", "m^3", "of one gap region", &C::volume},
          {"inner", "m", "a place inside it", &C::inner},
          {"safe_components", "", "list: numbers of the safe regions that it touches", &C::safe_neighbours},
          json_list<C>("sides", side_keys(), &C::sides, "list: the sides of the bridge")};
}

// Gaps and the regions that they connect, largest first.
std::vector<RegionComponent> gaps_of(const RegionSummary& regions) {
  std::vector<RegionComponent> gaps;
  for (const RegionComponent& c : regions.components)
    if (c.label == Label::gap && gaps.size() < most_gaps) gaps.push_back(c);
  return gaps;
}

Json component_counts(const RegionsShown& r) {
  Json counts;
  for (const Label label : all_labels) counts[std::string(name(label))] = r.regions.component_count[label];
  return counts;
}

}  // namespace

const JsonKeys<RegionsShown>& region_keys() {
  using R = RegionsShown;
  static const JsonKeys<R> keys{
      {"volume.LABEL", "m^3", "of the box", [](const R& r) { return by_label(r.regions.volume); }},
      {"components.LABEL", "", "connected regions", component_counts},
      json_list<R>(
          "gaps", gap_keys(), [](const R& r) { return gaps_of(r.regions); }, "list, largest first"),
      {"gaps_left_out", "", "gaps beyond those listed",
       [](const R& r) {
         const std::size_t all = r.regions.component_count[Label::gap];
         return all - gaps_of(r.regions).size();
       }},
      {"fill_distance", "m", "largest distance of a place of the box to its nearest state, as found",
       [](const R& r) { return r.holes.fill_distance; }},
      {"fill_distance_bound", "m", "an upper bound of it", [](const R& r) { return r.holes.fill_bound; }},
      {"largest_hole.radius", "m", "of the largest empty ball; null: none",
       [](const R& r) { return r.holes.largest ? r.holes.largest->radius : unknown; }},
      {"largest_hole.centre", "m", "its centre", [](const R& r) {
         return r.holes.largest ? r.holes.largest->centre : Vec3::Constant(unknown).eval();
       }}};
  return keys;
}

namespace {

struct ClassifiedShown {
  const ClassifiedPoints& result;
  const ClassifyArguments& arguments;
};
using C = ClassifiedShown;

// A list with a value for each point.
template <class Get>
auto of_points(Get get) {
  return [get](const C& c) {
    Json list = Json::array();
    for (const Coverage& at : c.result.found) list.push_back(*json_value(std::invoke(get, at)));
    return list;
  };
}

constexpr double enough_of_hull = 0.5;  // safe; below it an estimated spacing is not what the user meant

double share_of_hull(const Classified& set, const HullSpacing& hull) {
  return hull.volume > 0 ? std::min(1.0, set.regions.volume[Label::safe] / hull.volume) : unknown;
}

JsonKeys<C> set_keys() {
  return {{"states", "", "usable", [](const C& c) { return c.result.set.states.size(); }},
          {"unusable", "", "failed solves in the file", [](const C& c) { return c.result.set.unusable; }},
          {"spacing", "m", "that counts as dense", [](const C& c) { return c.result.set.spacing; }},
          {"spacing_estimated", "", "true: estimated from the density of the states, since the file has none",
           [](const C& c) { return c.result.set.estimated_dimension > 0; }},
          {"hull.safe_share", "1",
           "of the hull of the states, where the spacing is estimated and they fill a volume; else null",
           [](const C& c) { return c.result.hull ? share_of_hull(c.result.set, *c.result.hull) : unknown; }},
          {"hull.spacing_90", "m", "at which about 90 % of the hull would be safe",
           [](const C& c) { return c.result.hull ? c.result.hull->spacing : unknown; }},
          {"box", "m", "low and high corner; of states in a turned plane, in axes of the plane",
           [](const C& c) {
             return Json{vector3(c.result.set.box.low), vector3(c.result.set.box.high)};
           }},
          {"index", "", "delaunay or octree", [](const C& c) { return c.arguments.space.index; }},
          {"adaptive", "", "true: the spacing varies from place to place",
           [](const C& c) { return c.result.set.lattice != nullptr; }}};
}

const JsonKeys<C>& classified_keys() {
  static const JsonKeys<C> keys = [] {
    JsonKeys<C> all{{"labels", "", "list: safe, sparse, gap or blank of each point",
                     of_points([](const Coverage& at) { return name(at.label); })},
                    {"spread", "m", "list: of each point; null: infinite", of_points(&Coverage::spread)},
                    {"alpha", "m", "list: circumradius; null: infinite", of_points(&Coverage::alpha)},
                    {"delta", "m", "list: distance to the nearest state", of_points(&Coverage::delta)},
                    {"gamma_deg", "degrees", "list: half-angle of the largest empty cone; null: not needed",
                     of_points(&Coverage::gamma_deg)},
                    JsonKey<C>(declared(region_keys()), [](Json& document, const C& c) {
                      add_to(document, region_keys(), {c.result.set.regions, c.result.set.holes});
                    })};
    const JsonKeys<C> more{
        json_part<C>(agreement_keys(),
                     [](const C& c) { return c.result.agreement ? &*c.result.agreement : nullptr; }),
        JsonKey<C>(declared(error_keys()),
                   [](Json& document, const C& c) {
                     if (c.result.errors)
                       add_to(document, error_keys(), {*c.result.errors, c.arguments.bars});
                   })
            .last(),
        {"leaves", "", "of the octree of regions",
         [](const C& c) { return c.result.set.regions.leaf_count; }},
        {"seconds", "s", "time to label", [](const C& c) { return c.result.seconds; }},
        {"peak_bytes", "bytes", "largest memory of the process", [](const C&) { return peak_bytes(); }}};
    const JsonKeys<C> of_set = set_keys();
    all.insert(all.end(), of_set.begin(), of_set.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return keys;
}

}  // namespace

DeclaredTable classify_output() {
  return {"classify.json", "Of classify --json, for one set of states.", declared(classified_keys())};
}

namespace {

constexpr std::size_t most_listed = 20;  // points, unless --list asks for all

void list_points(const std::vector<Vec3>& points, const std::vector<Coverage>& found, const Units& units,
                 const Globals& globals) {
  for (std::size_t i = 0; i < points.size(); ++i)
    answer(globals,
           fmt::format("{:>10.4g} {:>10.4g} {:>10.4g} {}  {:<6}  spread {}  alpha {}  delta {}  gamma {}",
                       units.length(points[i].x()), units.length(points[i].y()), units.length(points[i].z()),
                       units.of_length(), name(found[i].label), units.distance(found[i].spread),
                       units.distance(found[i].alpha), units.distance(found[i].delta),
                       std::isnan(found[i].gamma_deg) ? "not needed"
                                                      : fmt::format("{:.4g} deg", found[i].gamma_deg)));
}

// "1331 points: safe 343, sparse 386, gap 0, blank 602; --list prints each"
void count_points(const std::vector<Coverage>& found, const Globals& globals) {
  ByLabel<std::size_t> count{};
  for (const Coverage& c : found) ++count[c.label];
  std::string text;
  for (const Label label : all_labels)
    text += fmt::format("{} {} {}", text.empty() ? ":" : ",", name(label), count[label]);
  answer(globals, counted(found.size(), "point") + text + "; --list prints each");
}

std::string hull_in_words(const Classified& set, const HullSpacing& hull) {
  const double share = share_of_hull(set, hull);
  if (!std::isfinite(share)) return {};
  const std::string safe = fmt::format("{:.0f} % of the hull of the states is safe", 100 * share);
  if (share >= enough_of_hull) return safe;
  return safe + fmt::format(
                    " at the estimated spacing; --spacing {:.2g} would make about 90 % of it safe, and close "
                    "every gap narrower than that",
                    hull.spacing);
}

constexpr std::size_t gaps_said = 5;  // the largest
// By the dimension of the cloud.
constexpr const char* estimated_along[] = {"", " (estimated, along their strokes)",
                                           " (estimated, along their surface)", " (estimated)"};

void print_gaps(const Classified& set, const Units& units, const Globals& globals) {
  std::size_t gaps = 0;
  for (const RegionComponent& c : set.regions.components)
    if (c.label == Label::gap && ++gaps <= gaps_said)
      say(globals, fmt::format("gap of {:.4g} {} around {}: states {}, {} beside it", units.volume(c.volume),
                               units.of_volume(), units.place(c.inner),
                               c.sides.size() == 1 && c.sides[0].half_angle_deg > 90
                                   ? "all round"
                                   : "on " + counted(c.sides.size(), "side"),
                               counted(c.safe_neighbours.size(), "safe component")));
  if (const std::size_t all = set.regions.component_count[Label::gap]; all > gaps_said)
    say(globals, fmt::format("and {} more gaps; --json lists them", all - gaps_said));
}

void print_summary(const Classified& set, double seconds, const Globals& globals) {
  const Units units(set.spacing);
  double all = 0;
  for (const double v : set.regions.volume.values) all += v;
  answer(globals,
         fmt::format("{}, h = {}{}{}", counted(set.states.size(), "state"), units.distance(set.spacing),
                     set.estimated_dimension > 0 ? estimated_along[set.estimated_dimension]
                     : set.lattice               ? " at the finest"
                                                 : "",
                     set.unusable ? ", " + counted(set.unusable, "failed one") + " left out" : ""));
  for (const Label label : all_labels) {
    const double volume = set.regions.volume[label];
    const std::size_t components = set.regions.component_count[label];
    answer(globals, fmt::format("{:<7}{:>12.5g} {} {:>6.1f} %  {}", name(label), units.volume(volume),
                                units.of_volume(), all > 0 ? 100 * volume / all : 0.0,
                                counted(components, "component")));
  }
  print_gaps(set, units, globals);
  answer(globals, fmt::format("fill distance {} (in the box, the farthest from all states){}",
                              units.distance(set.holes.fill_distance),
                              set.holes.fill_bound > set.holes.fill_distance + 1.001e-3 * set.spacing
                                  ? ", at most " + units.distance(set.holes.fill_bound)
                                  : ""));
  if (set.holes.largest)
    answer(globals,
           fmt::format("largest hole of radius {} around {}", units.distance(set.holes.largest->radius),
                       units.place(set.holes.largest->centre)));
  say(globals, fmt::format("{:.3g} s, {:.0f} MB at most", seconds, 1e-6 * double(peak_bytes())));
}

}  // namespace

void print_classified(const Globals& globals, const ClassifyArguments& arguments,
                      const ClassifiedPoints& result) {
  if (globals.json) return print_json(document_of(classified_keys(), {result, arguments}));
  const std::string extension = std::filesystem::path(arguments.output).extension();
  if (arguments.places.list || (result.points.size() <= most_listed && extension != ".csv"))
    list_points(result.points, result.found, Units(result.set.spacing), globals);
  else if (!result.points.empty())
    count_points(result.found, globals);
  print_summary(result.set, result.seconds, globals);
  if (result.hull)
    if (const std::string line = hull_in_words(result.set, *result.hull); !line.empty())
      answer(globals, line);
  if (result.errors) tell_errors(globals, arguments, *result.errors);
  if (!arguments.output.empty() && extension != ".vtu")  // a .vtu names its three files itself
    say(globals, fmt::format("{}: {}",
                             extension != ".csv"     ? "picture"
                             : result.points.empty() ? "regions"
                                                     : "labels of the points",
                             arguments.output));
  if (result.agreement) print_agreement(globals, *result.agreement);
}

}  // namespace forefeel
