#include "solver/jet/site_cover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <unordered_map>

namespace forefeel {
namespace {

struct Sample {
  SurfacePlace place;
  Vec3 normal = Vec3::Zero();
  double squared = std::numeric_limits<double>::infinity();  // delta^2 to the nearest site
};

// Normals under the pad at the nodes, weighted by barycentric coordinates.
std::vector<Sample> draw(const SurfaceMap& map, const MovingPad& pad, std::size_t count) {
  std::map<NodeIndex, Vec3> at_node;
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    const std::array<Vec3, 3> corner = map.corners(static_cast<std::int32_t>(f));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [at, fresh] = at_node.try_emplace(map.facets()[f].corners[i], Vec3::Zero());
      if (fresh) at->second = pad.normal({static_cast<std::int32_t>(f), corner[i]});
    }
  }
  std::mt19937_64 random(20240501);
  std::vector<Sample> samples(count);
  for (Sample& sample : samples) {
    sample.place = map.random(random);
    const Vec3 share = map.barycentric(sample.place);
    for (std::size_t i = 0; i < 3; ++i)
      sample.normal += share[static_cast<int>(i)] * at_node.at(map.facet(sample.place).corners[i]);
    sample.normal.normalize();
  }
  return samples;
}

}  // namespace

std::vector<SurfacePlace> cover(const SurfaceMap& map, const MovingPad& pad, const Vec3& first,
                                const CoverOptions& options) {
  const double wanted = map.free_area() / (options.spacing * options.spacing);
  const auto count = static_cast<std::size_t>(std::clamp(options.places_per_site * wanted, 200.0, 4e5));
  std::vector<Sample> samples = draw(map, pad, count);
  const double length = normal_length * pad.radius(), enough = options.spacing * options.spacing;
  std::size_t next = 0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if ((samples[i].place.at - first).norm() < (samples[next].place.at - first).norm()) next = i;
  std::vector<SurfacePlace> sites;
  while (sites.size() < options.most_sites) {
    const Sample site = samples[next];
    sites.push_back(site.place);
    for (Sample& other : samples)
      other.squared =
          std::min(other.squared, (other.place.at - site.place.at).squaredNorm() +
                                      length * length * (other.normal - site.normal).squaredNorm());
    next =
        static_cast<std::size_t>(std::ranges::max_element(samples, {}, &Sample::squared) - samples.begin());
    if (samples[next].squared <= enough) break;
  }
  return sites;
}

EdgeDistances::EdgeDistances(const SurfaceMap& map) : map_(map) {
  NodeIndex most = 0;
  for (const SurfaceMap::Facet& facet : map.facets())
    for (const NodeIndex node : facet.corners) most = std::max(most, node);
  edges_.resize(std::size_t{most} + 1);
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    const std::array<Vec3, 3> corner = map.corners(static_cast<std::int32_t>(f));
    const Triangle& node = map.facets()[f].corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double length = (corner[i] - corner[j]).norm();
      edges_[node[i]].push_back({node[j], length});  // each edge twice, from both facets
      edges_[node[j]].push_back({node[i], length});
    }
  }
}

std::vector<NodeDistance> EdgeDistances::from(const SurfacePlace& place, double most) const {
  using Reached = std::pair<double, NodeIndex>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
  std::unordered_map<NodeIndex, double> done;
  const std::array<Vec3, 3> corner = map_.corners(place.facet);
  for (std::size_t i = 0; i < 3; ++i)
    open.emplace((corner[i] - place.at).norm(), map_.facet(place).corners[i]);
  while (!open.empty() && open.top().first < most) {
    const auto [distance, node] = open.top();
    open.pop();
    if (!done.try_emplace(node, distance).second) continue;
    for (const NodeDistance& edge : edges_[node])
      if (!done.contains(edge.node)) open.emplace(distance + edge.distance, edge.node);
  }
  std::vector<NodeDistance> list;
  for (const auto& [node, distance] : done) list.push_back({node, distance});
  std::ranges::sort(list, {}, &NodeDistance::node);
  return list;
}

}  // namespace forefeel
