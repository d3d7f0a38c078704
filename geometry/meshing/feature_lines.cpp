#include "geometry/meshing/feature_lines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <memory>

namespace forefeel {
namespace {

constexpr double sharp_cosine = 0.6427876;  // of 50 degrees between normals

Link link_of(NodeIndex a, NodeIndex b) {
  return {std::min(a, b), std::max(a, b)};
}

struct Side {
  Link link;
  std::size_t triangle;
};

std::vector<Side> sides_of(const Surface& surface) {
  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back({link_of(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]), t});
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return a.link != b.link ? a.link < b.link : a.triangle < b.triangle;
  });
  return sides;
}

// Edges whose two triangles differ in the sense of `apart`.
template <class Apart>
std::vector<Link> edges_between(const Surface& surface, const Apart& apart) {
  std::vector<Link> result;
  const std::vector<Side> sides = sides_of(surface);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].link == sides[i + 1].link && apart(sides[i].triangle, sides[i + 1].triangle))
      result.push_back(sides[i].link);
  return result;
}

// A polygon of three to five nodes, cut into triangles around its node `from`.
void add_fan(std::vector<Triangle>& into, const std::vector<NodeIndex>& polygon, std::size_t from) {
  const std::size_t n = polygon.size();
  for (std::size_t k = 1; k + 1 < n; ++k)
    into.push_back({polygon[from], polygon[(from + k) % n], polygon[(from + k + 1) % n]});
}

}  // namespace

double rim_level(const Box& box, const LowEnd& low_end) {
  const auto k = static_cast<Eigen::Index>(low_end.axis);
  return box.low[k] + low_end.share * (box.high[k] - box.low[k]);
}

void cut_at(Surface& surface, Axis axis, double level) {
  const auto k = static_cast<Eigen::Index>(axis);
  std::map<Link, NodeIndex> made;
  const auto height = [&](NodeIndex node) { return surface.nodes[node][k] - level; };
  const auto crossing = [&](NodeIndex a, NodeIndex b) {
    const Link link = link_of(a, b);
    const auto [at, fresh] = made.emplace(link, static_cast<NodeIndex>(surface.nodes.size()));
    if (fresh) {
      const Vec3 from = surface.nodes[link[0]], to = surface.nodes[link[1]];
      Vec3 node = from + height(link[0]) / (height(link[0]) - height(link[1])) * (to - from);
      node[k] = level;
      surface.nodes.push_back(node);
    }
    return at->second;
  };
  std::vector<Triangle> triangles;
  for (const Triangle& t : surface.triangles) {
    std::vector<NodeIndex> low, high;  // the polygons on both sides, in the triangle's sense
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex a = t[i], b = t[(i + 1) % 3];
      if (height(a) <= 0) low.push_back(a);
      if (height(a) >= 0) high.push_back(a);
      if ((height(a) < 0 && height(b) > 0) || (height(a) > 0 && height(b) < 0)) {
        const NodeIndex node = crossing(a, b);
        low.push_back(node), high.push_back(node);
      }
    }
    const auto above = [&](NodeIndex node) { return height(node) > 0; };
    const auto below = [&](NodeIndex node) { return height(node) < 0; };
    if (std::ranges::none_of(t, above) || std::ranges::none_of(t, below))
      triangles.push_back(t);
    else
      add_fan(triangles, low, 0), add_fan(triangles, high, 0);
  }
  surface.triangles = std::move(triangles);
}

std::vector<Link> borders(const Surface& surface, std::span<const int> marks) {
  return edges_between(surface, [&](std::size_t s, std::size_t t) { return marks[s] != marks[t]; });
}

std::vector<int> marks_below(const Surface& surface, Axis axis, double level) {
  const auto k = static_cast<Eigen::Index>(axis);
  std::vector<int> marks;
  for (const Triangle& t : surface.triangles)
    marks.push_back(std::ranges::all_of(t, [&](NodeIndex node) { return surface.nodes[node][k] <= level; }));
  return marks;
}

std::vector<Link> sharp_edges(const Surface& surface) {
  std::vector<Vec3> normals;
  for (const auto& [a, b, c] : surface.triangles)
    normals.push_back(
        (surface.nodes[b] - surface.nodes[a]).cross(surface.nodes[c] - surface.nodes[a]).normalized());
  return edges_between(
      surface, [&](std::size_t s, std::size_t t) { return normals[s].dot(normals[t]) < sharp_cosine; });
}

std::vector<NodeIndex> corners_of(const Surface& surface, std::span<const Link> lines, double turn_cosine) {
  std::map<NodeIndex, std::vector<NodeIndex>> neighbours;
  for (const auto& [a, b] : lines) neighbours[a].push_back(b), neighbours[b].push_back(a);
  std::vector<NodeIndex> corners;
  for (const auto& [node, ends] : neighbours) {
    const auto towards = [&surface, &from = node, &to = ends](std::size_t i) -> Vec3 {
      return (surface.nodes[to[i]] - surface.nodes[from]).normalized();
    };
    if (ends.size() != 2 || -towards(0).dot(towards(1)) < turn_cosine) corners.push_back(node);
  }
  return corners;
}

std::function<Vec3(const Vec3&)> nearest_on_lines(const Surface& surface, std::span<const Link> lines) {
  const auto segments = std::make_shared<std::vector<std::array<Vec3, 2>>>();
  for (const auto& [a, b] : lines) segments->push_back({surface.nodes[a], surface.nodes[b]});
  return [segments](const Vec3& p) {
    Vec3 best = p;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : *segments) {
      const Vec3 along = b - a;
      const double squared = along.squaredNorm();
      const double t = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
      const Vec3 point = t < 1 ? Vec3(a + t * along) : b;
      const double distance = (point - p).squaredNorm();
      if (distance < least) least = distance, best = point;
    }
    return best;
  };
}

}  // namespace forefeel
