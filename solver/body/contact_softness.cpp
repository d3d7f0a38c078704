#include "solver/body/contact_softness.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "solver/body/contact_stiffness.hpp"

namespace forefeel {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

std::vector<std::vector<NodeIndex>> neighbours(const TetMesh& mesh) {
  std::vector<std::vector<NodeIndex>> of(mesh.nodes.size());
  for (const Tet& tet : mesh.tets)
    for (const NodeIndex a : tet)
      for (const NodeIndex b : tet)
        if (a != b) of[static_cast<std::size_t>(a)].push_back(b);
  for (std::vector<NodeIndex>& list : of) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return of;
}

// Distance of each node from the patch along edges of the mesh [m] (Dijkstra).
std::vector<double> distances(const Body& body) {
  const TetMesh& mesh = body.mesh;
  const std::vector<std::vector<NodeIndex>> near = neighbours(mesh);
  std::vector<double> distance(mesh.nodes.size(), infinite);
  using Item = std::pair<double, NodeIndex>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  for (const NodeIndex node : body.contact) {
    distance[static_cast<std::size_t>(node)] = 0;
    open.push({0, node});
  }
  while (!open.empty()) {
    const auto [d, node] = open.top();
    open.pop();
    const auto here = static_cast<std::size_t>(node);
    if (d > distance[here]) continue;
    for (const NodeIndex other : near[here]) {
      const auto there = static_cast<std::size_t>(other);
      const double longer = d + (mesh.nodes[there] - mesh.nodes[here]).norm();
      if (longer >= distance[there]) continue;
      distance[there] = longer;
      open.push({longer, other});
    }
  }
  return distance;
}

// Moments of the part of a body between two distances, weighted by E / E_0.
struct Section {
  double volume = 0;
  Vec3 first = Vec3::Zero();      // int x dV
  Mat3 second = Mat3::Zero();     // int x x^T dV
  Vec3 direction = Vec3::Zero();  // int grad s dV

  // The least variance of its points across the mean direction of s [m^2].
  double least_variance() const {
    const Vec3 mean = first / volume, g = direction / volume;
    Mat3 variance = second / volume - mean * mean.transpose();
    variance += 4 * variance.trace() * g * g.transpose();
    return std::max(Eigen::SelfAdjointEigenSolver<Mat3>(variance, Eigen::EigenvaluesOnly).eigenvalues()[0],
                    0.0);
  }
};

struct Sections {
  std::vector<Section> bins;
  double width = 0;  // of a bin [m]
};

// E / E_0 of each tetrahedron.
std::vector<double> relative_young(const Body& body, double young_at_patch) {
  std::vector<double> relative(body.mesh.tets.size(), body.material.young / young_at_patch);
  for (const MaterialRegion& region : body.regions)
    for (const TetIndex tet : region.tets)
      relative[static_cast<std::size_t>(tet)] = region.material.young / young_at_patch;
  return relative;
}

// Distributes each tetrahedron evenly over the range of its nodes' distances.
Sections sections(const Body& body, const std::vector<double>& distance, double end, double young_at_patch) {
  constexpr std::size_t count = 48;
  Sections cut{.bins = std::vector<Section>(count), .width = end / count};
  const std::vector<double> relative = relative_young(body, young_at_patch);
  for (std::size_t t = 0; t < body.mesh.tets.size(); ++t) {
    const Tet& tet = body.mesh.tets[t];
    std::array<double, 4> s{};
    Vec3 centre = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      s[i] = distance[static_cast<std::size_t>(tet[i])];
      centre += body.mesh.nodes[static_cast<std::size_t>(tet[i])] / 4;
    }
    const double low = std::ranges::min(s), high = std::max(std::ranges::max(s), low + 1e-9 * end);
    if (!(low < end)) continue;
    Mat3 edges;  // rows
    Vec3 rise;
    Mat3 spread = Mat3::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 x = body.mesh.nodes[static_cast<std::size_t>(tet[i])];
      spread += (x - centre) * (x - centre).transpose() / 20;
      if (i == 0) continue;
      edges.row(static_cast<int>(i) - 1) = x - body.mesh.nodes[static_cast<std::size_t>(tet[0])];
      rise[static_cast<int>(i) - 1] = s[i] - s[0];
    }
    const double volume = relative[t] * std::abs(edges.determinant()) / 6;
    const Vec3 gradient = edges.inverse() * rise;
    const auto first = static_cast<std::size_t>(low / cut.width);
    for (std::size_t b = first; b < count && static_cast<double>(b) * cut.width < high; ++b) {
      const double from = std::max(low, static_cast<double>(b) * cut.width),
                   to = std::min(high, static_cast<double>(b + 1) * cut.width);
      const double part = volume * std::max(0.0, to - from) / (high - low);
      Section& bin = cut.bins[b];
      bin.volume += part;
      bin.first += part * centre;
      bin.second += part * (centre * centre.transpose() + spread);
      bin.direction += part * gradient;
    }
  }
  return cut;
}

// c times Young's modulus [1/m].
double compliance(const Sections& cut) {
  double stretch = 0, weight = 0, mean = 0, square = 0;
  for (std::size_t b = 0; b < cut.bins.size(); ++b) {
    const Section& bin = cut.bins[b];
    if (!(bin.volume > 0)) return infinite;
    const double area = bin.volume / cut.width, s = (static_cast<double>(b) + 0.5) * cut.width;
    stretch += cut.width / area;
    const double bending = cut.width / (area * bin.least_variance());
    weight += bending;
    mean += bending * s;
    square += bending * s * s;
  }
  return stretch + std::max(0.0, square - mean * mean / weight);
}

// Distances from the patch, and that of the nearest clamped node [m].
struct Reach {
  std::vector<double> distance;
  double clamp = infinite;
  bool reached() const { return clamp > 0 && clamp < infinite; }
};

Reach reach_of(const Body& body) {
  Reach reach{.distance = distances(body)};
  for (const NodeIndex node : body.clamp)
    reach.clamp = std::min(reach.clamp, reach.distance[static_cast<std::size_t>(node)]);
  return reach;
}

double radius_of_patch(const Body& body) {
  return std::sqrt(contact_area(body) / std::numbers::pi);
}

double softness(const Body& body, const Mat3& disc, const Reach& reach) {
  if (disc.isZero(0)) return 0;
  if (!reach.reached()) return infinite;
  const double stiffest = Eigen::SelfAdjointEigenSolver<Mat3>(disc, Eigen::EigenvaluesOnly).eigenvalues()[2];
  const double young = patch_material(body)->young;  // exists: without it, the disc's stiffness is zero
  return stiffest * compliance(sections(body, reach.distance, reach.clamp, young)) / young;
}

double breadth(const Body& body, const Reach& reach) {
  if (!reach.reached()) return 0;
  const double end = 1.6 * reach.clamp + radius_of_patch(body);
  double area = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const Triangle& triangle : boundary_triangles(body.mesh)) {
    const auto corner = [&](std::size_t i) { return body.mesh.nodes[static_cast<std::size_t>(triangle[i])]; };
    const double third = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 3;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!std::ranges::binary_search(body.clamp, triangle[i])) continue;
      if (reach.distance[static_cast<std::size_t>(triangle[i])] > end) continue;
      area += third;
      first += third * corner(i);
      second += third * corner(i) * corner(i).transpose();
    }
  }
  if (!(area > 0)) return 0;
  Vec3 patch = Vec3::Zero();
  for (const NodeIndex node : body.contact)
    patch += body.mesh.nodes[static_cast<std::size_t>(node)] / static_cast<double>(body.contact.size());
  const Vec3 centre = first / area, line = centre - patch;
  if (!(line.norm() > 1e-6 * reach.clamp)) return infinite;
  const Vec3 u = line.normalized();
  const Mat3 across = Mat3::Identity() - u * u.transpose();
  Mat3 variance = across * (second / area - centre * centre.transpose()) * across;
  variance += variance.trace() * u * u.transpose();  // so that the line itself is not the least
  const double least = Eigen::SelfAdjointEigenSolver<Mat3>(variance, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return std::sqrt(std::max(least, 0.0)) / line.norm();
}

constexpr double least_breadth = 0.32, least_depth = 4, most_poisson = 0.46;
constexpr std::size_t least_nodes = 6;

std::string why_left_out(const Body& body, double softness, const Reach& reach) {
  const std::optional<Material> material = patch_material(body);
  if (!material) return "several materials lie at the contact";
  if (!(softness <= most_softness))
    return fmt::format("the body is about {:.2g} times softer at its contact than a block of its material",
                       softness);
  if (breadth(body, reach) < least_breadth) return "the body can rock on its clamp, which is narrow";
  if (reach.clamp < least_depth * radius_of_patch(body))
    return "the clamp is so near that the body is stiffer than a block";
  if (body.contact.size() < least_nodes)
    return fmt::format("the contact has {} nodes of the mesh, and fewer than {} say too little of its size",
                       body.contact.size(), least_nodes);
  if (body.element == Element::linear && material->poisson > most_poisson)
    return fmt::format("linear elements lock at a Poisson ratio of {:g}", material->poisson);
  return {};
}

}  // namespace

double contact_softness(const Body& body) {
  return softness(body, disc_stiffness(body), reach_of(body));
}

double clamp_breadth(const Body& body) {
  return breadth(body, reach_of(body));
}

FirstGuess first_guess(const Body& body) {
  const Mat3 disc = disc_stiffness(body);
  const Reach reach = reach_of(body);
  FirstGuess guess{.softness = softness(body, disc, reach), .left_out = {}};
  guess.left_out = why_left_out(body, guess.softness, reach);
  if (guess.left_out.empty()) guess.stiffness = disc;
  return guess;
}

}  // namespace forefeel
