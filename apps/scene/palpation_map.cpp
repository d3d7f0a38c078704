#include "apps/scene/palpation_map.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "apps/console/console.hpp"
#include "geometry/common/counted.hpp"

namespace forefeel {
namespace {

Json range_json(const std::optional<StiffnessRange>& range) {
  return range ? json_numbers({range->least, range->median, range->greatest}) : Json();
}

// Of the free nodes of the surface, a third of each of their facets [m^2].
std::map<NodeIndex, double> areas_of_nodes(const Body& body) {
  const SurfaceMap surface(body);
  std::map<NodeIndex, double> areas;
  for (const SurfaceMap::Facet& facet : surface.facets())
    for (const NodeIndex node : facet.corners)
      if (!facet.clamped && !std::ranges::binary_search(body.clamp, node)) areas[node] += facet.area / 3;
  return areas;
}

}  // namespace

std::vector<SurfaceStiffness> palpation_map(const RestSites& rest, const Body& body, int threads) {
  const std::map<NodeIndex, double> areas = areas_of_nodes(body);
  std::vector<SurfaceStiffness> list;
  for (const auto& [node, area] : areas) list.push_back({.node = node, .area = area});
#pragma omp parallel for schedule(dynamic) num_threads(threads > 0 ? threads : omp_get_max_threads())
  for (std::size_t i = 0; i < list.size(); ++i) {
    const SiteRest at = rest.at(rest.map().nearest(body.mesh.nodes[list[i].node]), false);
    if (at.normal.isZero()) continue;
    list[i].with_pad = at.normal.dot(at.stiffness * at.normal);
    list[i].alone = at.normal.dot(at.body_stiffness() * at.normal);
  }
  std::erase_if(list, [](const SurfaceStiffness& at) { return at.with_pad == 0; });
  return list;
}

std::vector<SurfaceError> error_map(const DeepStates& known, const Body& body, double depth, double floor,
                                    int threads) {
  std::vector<SurfaceError> list;
  for (const auto& [node, area] : areas_of_nodes(body)) list.push_back({.node = node, .area = area});
  const SiteField& field = known.field();
#pragma omp parallel for schedule(dynamic) num_threads(threads > 0 ? threads : omp_get_max_threads())
  for (std::size_t i = 0; i < list.size(); ++i) {
    const SurfacePlace place = field.rest().map().nearest(body.mesh.nodes[list[i].node]);
    const SiteModel model = field.at(place, false);
    const Vec3 x = -depth * model.rest().normal;
    list[i].error =
        3 * known.estimated_error(model, place, x) / std::max(known.at(model, place, x).force.norm(), floor);
  }
  return list;
}

std::optional<StiffnessRange> range_over(const std::vector<SurfaceStiffness>& map,
                                         double SurfaceStiffness::*which) {
  if (map.empty()) return {};
  std::vector<SurfaceStiffness> sorted = map;
  std::ranges::sort(sorted, {}, which);
  const double half =
      0.5 * std::accumulate(map.begin(), map.end(), 0.0,
                            [](double sum, const SurfaceStiffness& at) { return sum + at.area; });
  auto middle = sorted.begin();
  for (double sum = middle->area; sum < half && middle + 1 != sorted.end();) sum += (++middle)->area;
  return StiffnessRange{sorted.front().*which, (*middle).*which, sorted.back().*which};
}

FieldNote field_note(const Scene& scene, const FieldFound& found, const Globals& globals) {
  const SiteField& field = *found.field;
  const std::vector<SurfaceStiffness> map = palpation_map(field.rest(), *scene.body, globals.threads);
  return {.sites = field.size(),
          .spacing = field.options().spacing,
          .seconds = found.seconds,
          .kept = found.kept,
          .area = field.rest().map().free_area(),
          .lift = field.rest().map().smooth().farthest(),
          .kept_edges = field.rest().map().smooth().kept_edges(),
          .faceted_nodes = field.rest().map().smooth().faceted_nodes(),
          .with_pad = range_over(map, &SurfaceStiffness::with_pad),
          .alone = range_over(map, &SurfaceStiffness::alone),
          .friction = scene.touch.anywhere->friction};
}

const JsonKeys<FieldNote>& field_keys() {
  using F = FieldNote;
  static const JsonKeys<F> keys{
      {"sites", "", "places of the surface whose jets at rest make the field", &F::sites},
      {"spacing", "m", "of the sites", &F::spacing},
      {"seconds", "s", "that making or reading it took", &F::seconds},
      {"kept", "", "true: it was read from the cache", &F::kept},
      {"area", "m^2", "of the surface that is not clamped", &F::area},
      {"lift", "m", "of the smooth surface that a tip slides over from the mesh's facets, at most", &F::lift},
      {"kept_edges", "", "edges of the mesh that the smooth surface keeps: sharper than 40 degrees",
       &F::kept_edges},
      {"faceted_nodes", "", "nodes around which it would fold and stays that of the facets",
       &F::faceted_nodes},
      {"stiffness", "N/m",
       "[least, median, greatest] over the surface's area, at rest, along the normal, with the pad",
       [](const F& f) { return range_json(f.with_pad); }},
      {"body_stiffness", "N/m", "the same of the body alone under the pad",
       [](const F& f) { return range_json(f.alone); }},
      {"friction", "1", "coefficient of tip and surface; null: bonded",
       [](const F& f) { return f.friction; }}};
  return keys;
}

std::vector<std::string> in_words(const FieldNote& note) {
  std::vector<std::string> lines{
      fmt::format("{} sites {:.3g} mm apart over {:.3g} cm2, {} in {:.3g} s", note.sites, 1e3 * note.spacing,
                  1e4 * note.area, note.kept ? "read from the cache" : "solved", note.seconds),
      fmt::format("smooth surface within {:.2g} mm of the mesh, {} kept{}", 1e3 * note.lift,
                  counted(note.kept_edges, "sharp edge"),
                  note.faceted_nodes > 0
                      ? fmt::format(", {} with flat facets", counted(note.faceted_nodes, "node"))
                      : "")};
  const auto add = [&](const std::optional<StiffnessRange>& range, const char* what) {
    if (range)
      lines.push_back(
          fmt::format("stiffness at rest along the normal, {}: {:.4g} to {:.4g} N/m, median {:.4g}", what,
                      range->least, range->greatest, range->median));
  };
  add(note.with_pad, "with the pad");
  add(note.alone, "body alone");
  lines.push_back(note.friction ? fmt::format("a tip slides beyond friction {:g}", *note.friction)
                                : std::string("a tip is bonded: it never slides"));
  return lines;
}

}  // namespace forefeel
