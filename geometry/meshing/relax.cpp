#include "geometry/meshing/relax.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace forefeel {
namespace {

constexpr int rounds = 30, smoothings = 6;  // relaxation: rounds of smoothing, each followed by flips

struct Icosahedron {
  std::array<Vec3, 12> nodes;
  std::array<Triangle, 20> triangles{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
  Icosahedron() {
    const double t = (1 + std::sqrt(5.0)) / 2;
    nodes = {Vec3(-1, t, 0), Vec3(1, t, 0), Vec3(-1, -t, 0), Vec3(1, -t, 0),
             Vec3(0, -1, t), Vec3(0, 1, t), Vec3(0, -1, -t), Vec3(0, 1, -t),
             Vec3(t, 0, -1), Vec3(t, 0, 1), Vec3(-t, 0, -1), Vec3(-t, 0, 1)};
  }
};

Vec3 area_vector(const Surface& surface, const Triangle& t) {
  const Vec3& a = surface.nodes[t[0]];
  return (surface.nodes[t[1]] - a).cross(surface.nodes[t[2]] - a);
}

// One Jacobi step: each node moves to the area-weighted mean of the centroids around it, and back onto the
// surface.
void smooth(const ImplicitSurface& body, Surface& surface, const std::vector<char>& fixed) {
  std::vector<Vec3> sum(surface.nodes.size(), Vec3::Zero());
  std::vector<double> weight(surface.nodes.size(), 0);
  for (const Triangle& t : surface.triangles) {
    const double area = area_vector(surface, t).norm();
    const Vec3 centroid = (surface.nodes[t[0]] + surface.nodes[t[1]] + surface.nodes[t[2]]) / 3;
    for (const NodeIndex node : t) sum[node] += area * centroid, weight[node] += area;
  }
  for (std::size_t i = 0; i < surface.nodes.size(); ++i) {
    if (fixed[i] || !(weight[i] > 0)) continue;
    const Vec3 normal = body.gradient(surface.nodes[i]).normalized();
    Vec3 step = sum[i] / weight[i] - surface.nodes[i];
    step -= normal.dot(step) * normal;
    surface.nodes[i] = project_onto(body, surface.nodes[i] + step);
  }
}

double cotangent(const Vec3& at, const Vec3& b, const Vec3& c) {
  return (b - at).dot(c - at) / (b - at).cross(c - at).norm();
}

struct Edge {
  NodeIndex a, b;  // a < b
  std::uint32_t triangle;
  std::uint8_t corner;  // opposite the edge
};

// Turns edges whose opposite angles sum to more than 180 degrees, where the new triangles do not fold. True
// if any.
bool flip_pass(Surface& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const NodeIndex a = surface.triangles[t][(k + 1) % 3], b = surface.triangles[t][(k + 2) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, k});
    }
  std::ranges::sort(edges, [](const Edge& x, const Edge& y) {
    return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle);
  });
  std::vector<char> touched(surface.triangles.size(), 0);
  const auto joined = [&](NodeIndex a, NodeIndex b) {
    const auto key = std::pair(std::min(a, b), std::max(a, b));
    const auto at =
        std::ranges::lower_bound(edges, key, {}, [](const Edge& e) { return std::pair(e.a, e.b); });
    return at != edges.end() && std::pair(at->a, at->b) == key;
  };
  bool any = false;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const Edge &x = edges[i], &y = edges[i + 1];
    if (x.a != y.a || x.b != y.b || touched[x.triangle] || touched[y.triangle]) continue;
    Triangle &s = surface.triangles[x.triangle], &t = surface.triangles[y.triangle];
    const NodeIndex p = s[x.corner], q = t[y.corner], a = s[(x.corner + 1) % 3], b = s[(x.corner + 2) % 3];
    const auto& nodes = surface.nodes;
    if (cotangent(nodes[p], nodes[a], nodes[b]) + cotangent(nodes[q], nodes[a], nodes[b]) >= -1e-9 ||
        joined(p, q))
      continue;
    const Triangle first{p, a, q}, second{q, b, p};
    const Vec3 normal = area_vector(surface, s) + area_vector(surface, t);
    if (area_vector(surface, first).dot(normal) <= 0 || area_vector(surface, second).dot(normal) <= 0)
      continue;
    s = first, t = second;
    touched[x.triangle] = touched[y.triangle] = 1;
    any = true;
  }
  return any;
}

void relax(const ImplicitSurface& body, Surface& surface, const std::vector<char>& fixed) {
  for (int round = 0; round < rounds; ++round) {
    for (int k = 0; k < smoothings; ++k) smooth(body, surface, fixed);
    for (int k = 0; k < 20 && flip_pass(surface); ++k) {
    }
  }
}

}  // namespace

Surface geodesic_sphere(int n) {
  const Icosahedron base;
  Surface result;
  // Points of the subdivided faces, merged along edges by their weights on the icosahedron's nodes.
  std::map<std::array<std::pair<NodeIndex, int>, 3>, NodeIndex> known;
  const auto point = [&](const Triangle& face, int i, int j) {
    std::array<std::pair<NodeIndex, int>, 3> key{{{face[0], n - i - j}, {face[1], i}, {face[2], j}}};
    for (auto& [node, weight] : key)
      if (weight == 0) node = 0;
    std::ranges::sort(key);
    const auto [at, is_new] = known.emplace(key, static_cast<NodeIndex>(result.nodes.size()));
    if (is_new) {
      Vec3 sum = Vec3::Zero();
      for (const auto& [node, weight] : key)
        if (weight > 0) sum += weight * base.nodes[node];
      result.nodes.push_back(sum / std::sqrt(sum.dot(sum)));
    }
    return at->second;
  };
  for (const Triangle& face : base.triangles)
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        result.triangles.push_back({point(face, i, j), point(face, i + 1, j), point(face, i, j + 1)});
        if (i + j + 1 < n)
          result.triangles.push_back(
              {point(face, i + 1, j), point(face, i + 1, j + 1), point(face, i, j + 1)});
      }
  return result;
}

Vec3 project_onto(const ImplicitSurface& body, Vec3 point) {
  for (int k = 0; k < 30; ++k) {
    const double value = body.value(point);
    const Vec3 gradient = body.gradient(point);
    const Vec3 step = value / gradient.squaredNorm() * gradient;
    point -= step;
    if (step.squaredNorm() < 1e-24 * body.reach * body.reach) break;
  }
  return point;
}

Vec3 last_crossing(const ImplicitSurface& body, const Vec3& from, const Vec3& direction) {
  double low = 0, high = body.reach;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (body.value(from + middle * direction) > 0 ? low : high) = middle;
  }
  return from + low * direction;
}

Surface triangulate_implicit(const ImplicitSurface& body, int n, std::span<const Vec3> pins) {
  Surface surface = geodesic_sphere(n);
  for (Vec3& node : surface.nodes) node = last_crossing(body, body.centre, node);
  std::vector<char> fixed(surface.nodes.size(), 0);
  relax(body, surface, fixed);
  for (const Vec3& pin : pins) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < surface.nodes.size(); ++i)
      if ((surface.nodes[i] - pin).squaredNorm() < (surface.nodes[best] - pin).squaredNorm()) best = i;
    surface.nodes[best] = pin, fixed[best] = 1;
  }
  if (!pins.empty()) relax(body, surface, fixed);
  return surface;
}

}  // namespace forefeel
