#include "solver/body/contact_stiffness.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "solver/body/pad.hpp"

namespace forefeel {

namespace {

// The pressure (1 - y^2 / r^2)^2 on a half-space moves its own weighted mean as far as a disc of this share of r:
// pi / (2 I), I = 2304 int_0^inf J_3(k)^2 / k^6 dk = 2.4082 (Hankel transform; Watson, Bessel Functions, 13.41).
constexpr double pad_as_disc = 0.6523;

struct Patch {
  double area = 0;             // [m^2]
  Vec3 normal = Vec3::Zero();  // outward
};

Patch contact_patch(const Body& body) {
  Patch patch;
  if (body.pad) {
    const PadSurface surface = pad_surface(body.mesh, *body.pad);
    return {surface.area, surface.normal.isZero() ? Vec3(Vec3::UnitZ()) : surface.normal};
  }
  for (const Triangle& triangle : boundary_triangles(body.mesh)) {
    const auto touched = std::ranges::count_if(
        triangle, [&](NodeIndex node) { return std::ranges::binary_search(body.contact, node); });
    if (touched == 0) continue;
    const auto corner = [&](std::size_t i) { return body.mesh.nodes[triangle[i]]; };
    const Vec3 area = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0));
    const double tributary = static_cast<double>(touched) / 3;
    patch.area += 0.5 * (tributary + (touched == 3 ? 1 : 0)) * area.norm();
    patch.normal += tributary * area;
  }
  patch.normal = patch.normal.norm() > 0 ? Vec3(patch.normal.normalized()) : Vec3(Vec3::UnitZ());
  return patch;
}

}  // namespace

double contact_area(const Body& body) {
  return contact_patch(body).area;
}

std::optional<Material> patch_material(const Body& body) {
  if (body.regions.empty()) return body.material;
  const TetMesh& mesh = body.mesh;
  const double reach = 2 * (body.pad ? pad_as_disc * body.pad->radius
                                     : std::sqrt(contact_patch(body).area / std::numbers::pi));
  std::vector<char> near(mesh.nodes.size(), 0);
  for (std::size_t node = 0; node < near.size(); ++node)
    near[node] = body.pad ? (mesh.nodes[node] - body.pad->site).norm() <= reach
                          : std::ranges::any_of(body.contact, [&](NodeIndex touched) {
                              return (mesh.nodes[node] - mesh.nodes[touched]).norm() <= reach;
                            });
  std::optional<Material> found;
  for (const MaterialPart& part : material_parts(body)) {
    const bool at_patch = std::ranges::any_of(part.tets, [&](TetIndex tet) {
      return std::ranges::any_of(mesh.tets[tet], [&](NodeIndex node) { return near[node] != 0; });
    });
    if (!at_patch) continue;
    if (found) return {};
    found = part.material;
  }
  return found;
}

Mat3 disc_stiffness(const Body& body) {
  const Patch patch = contact_patch(body);
  const std::optional<Material> material = patch_material(body);
  if (!material) return Mat3::Zero();
  const auto [law, young, poisson] = *material;
  const double shear = young / (2 * (1 + poisson)),
               a = body.pad ? pad_as_disc * body.pad->radius : std::sqrt(patch.area / std::numbers::pi);
  const double s = 1 - 2 * poisson;  // ln(1 + 2 s) / s tends to 2
  const double normal = 4 * shear * a * (s > 1e-8 ? std::log1p(2 * s) / s : 2);
  const double tangential = 8 * shear * a / (2 - poisson);
  const Mat3 disc =
      tangential * Mat3::Identity() + (normal - tangential) * patch.normal * patch.normal.transpose();
  if (!body.pad) return disc;
  const double springs = pad_surface(body.mesh, *body.pad).stiffness;
  return (disc.inverse() + Mat3::Identity() / springs).inverse();
}

namespace {

Mat3 stiffness_of(const TetMesh& mesh, const Tet& tet, const std::array<bool, 4>& moves,
                  const Material& material) {
  const auto node = [&](std::size_t i) -> const Vec3& { return mesh.nodes[tet[i]]; };
  Mat3 edges;
  for (unsigned i = 0; i < 3; ++i) edges.col(i) = node(i + 1) - node(0);
  const Mat3 gradients = edges.inverse();  // row i: grad N_(i + 1)
  Vec3 g = Vec3::Zero();
  for (unsigned i = 0; i < 3; ++i) {
    const Vec3 own = gradients.row(i);
    if (moves[i + 1]) g += own;
    if (moves[0]) g -= own;
  }
  const double e = material.young, nu = material.poisson;
  const double mu = e / (2 * (1 + nu)), lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
  const double volume = std::abs(edges.determinant()) / 6;
  return volume * ((lambda + mu) * g * g.transpose() + mu * g.squaredNorm() * Mat3::Identity());
}

}  // namespace

Mat3 contact_stiffness_bound(const Body& body) {
  if (body.pad) return pad_surface(body.mesh, *body.pad).stiffness * Mat3::Identity();
  std::vector<bool> in_contact(body.mesh.nodes.size(), false);
  for (const NodeIndex node : body.contact) in_contact[node] = true;
  Mat3 sum = Mat3::Zero();
  for (const MaterialPart& part : material_parts(body))
    for (const TetIndex t : part.tets) {
      const Tet& tet = body.mesh.tets[t];
      std::array<bool, 4> moves{};
      for (std::size_t i = 0; i < 4; ++i) moves[i] = in_contact[tet[i]];
      const auto moving = std::ranges::count(moves, true);
      if (moving > 0 && moving < 4) sum += stiffness_of(body.mesh, tet, moves, part.material);
    }
  return sum;
}

}  // namespace forefeel
