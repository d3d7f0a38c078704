#include "apps/sites/palpation_map.hpp"

#include <omp.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace forefeel {

std::vector<SurfaceStiffness> palpation_map(const RestSites& rest, const Body& body, int threads) {
  const SurfaceMap surface(body);
  std::map<NodeIndex, double> areas;
  for (const SurfaceMap::Facet& facet : surface.facets())
    for (const NodeIndex node : facet.corners)
      if (!facet.clamped && !std::ranges::binary_search(body.clamp, node)) areas[node] += facet.area / 3;
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

}  // namespace forefeel
