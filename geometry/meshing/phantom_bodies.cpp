#include "geometry/meshing/phantom_bodies.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

// Two blended ellipsoids, whose semi-axes r differ above and below the equator:
//   g_i = |(x - c_i) / r_i|^2,   f = 1 / g_1^2 + 1 / g_2^2 - 1
// The right lobe (x < 0) is thick, the left one thin; the underside is flat.
struct Lobe {
  Vec3 centre;
  double x, y, above, below;  // semi-axes [m]

  Vec3 weights(const Vec3& p) const {
    const double z = p.z() > centre.z() ? above : below;
    return {1 / (x * x), 1 / (y * y), 1 / (z * z)};
  }
  double form(const Vec3& p) const { return weights(p).dot((p - centre).cwiseAbs2()); }
  Vec3 form_gradient(const Vec3& p) const { return 2 * weights(p).cwiseProduct(p - centre); }
};

const std::array<Lobe, 2>& lobes() {
  static const std::array<Lobe, 2> both{Lobe{{-0.0425, 0, 0}, 0.0665, 0.062, 0.060, 0.036},
                                        Lobe{{0.0475, 0.012, -0.004}, 0.0595, 0.045, 0.032, 0.026}};
  return both;
}

const std::array<Blueprint, 4>& blueprints() {
  static const std::array<Blueprint, 4> all{
      Blueprint{"liver", 1777, liver().scale * liver().top}, Blueprint{"beam", 1920, {0.1, 0.01, 0.01}},
      Blueprint{"ball", 2000, {0, 0, 0.05}}, Blueprint{"slab", 3000, {0, 0, 0.04}}};
  return all;
}

}  // namespace

ImplicitSurface liver_body() {
  const auto value = [](const Vec3& p) {
    double sum = -1;
    for (const Lobe& lobe : lobes()) {
      const double g = lobe.form(p);
      sum += 1 / (g * g);
    }
    return sum;
  };
  const auto gradient = [](const Vec3& p) {
    Vec3 sum = Vec3::Zero();
    for (const Lobe& lobe : lobes()) {
      const double g = lobe.form(p);
      sum += -2 / (g * g * g) * lobe.form_gradient(p);
    }
    return sum;
  };
  return {value, gradient, Vec3(0.006, 0.004, 0), 0.2};
}

Vec3 extreme(const ImplicitSurface& body, const Vec3& direction) {
  Vec3 point = last_crossing(body, body.centre, direction);
  for (int k = 0; k < 200; ++k) {
    const Vec3 normal = body.gradient(point).normalized();
    point = project_onto(body, point + 0.02 * (direction - normal.dot(direction) * normal));
  }
  return point;
}

Liver::Liver() : top(last_crossing(unscaled, lobes()[0].centre, Vec3::UnitZ())) {}

Surface Liver::surface(int n) const {
  Surface result = triangulate_implicit(unscaled, n, std::array{top, left, right});
  for (Vec3& node : result.nodes) node *= scale;
  return result;
}

const Liver& liver() {
  static const Liver body;
  return body;
}

Box box_of(std::string_view name) {
  return name == "beam" ? Box{{0, 0, 0}, {0.1, 0.02, 0.02}} : Box{{-0.1, -0.1, 0}, {0.1, 0.1, 0.04}};
}

bool is_box(std::string_view name) {
  return name == "beam" || name == "slab";
}

std::vector<std::string> blueprint_names() {
  std::vector<std::string> names;
  for (const Blueprint& known : blueprints()) names.emplace_back(known.name);
  return names;
}

const Blueprint& blueprint(std::string_view name) {
  for (const Blueprint& known : blueprints())
    if (known.name == name) return known;
  throw InputError("phantom", fmt::format("'{}' is unknown, expected one of {}", name,
                                          fmt::join(blueprint_names(), ", ")));
}

void mark_lump(std::string_view name, TetMesh& mesh) {
  if (name != "slab") return;
  const Vec3 centre = blueprint(name).tip - Vec3(0, 0, 0.018);
  constexpr double radius = 0.012;
  for (TetIndex t = 0; t < mesh.tets.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (const NodeIndex node : mesh.tets[t]) middle += 0.25 * mesh.nodes[node];
    if ((middle - centre).norm() <= radius) mesh.element_groups["lump"].push_back(t);
  }
}

double phantom_patch(std::string_view name) {
  return name == "beam" ? 0.01 : 0.02;
}

bool within_share(std::size_t count, std::size_t asked) {
  return std::abs(static_cast<double>(count) - static_cast<double>(asked)) <
         0.0499 * static_cast<double>(asked);
}

Surface smooth_surface(std::string_view name, int n) {
  if (name == "ball") {
    Surface sphere = geodesic_sphere(n);
    for (Vec3& node : sphere.nodes) node *= 0.05;
    return sphere;
  }
  return liver().surface(n);
}

int frequency_for(std::size_t elements) {
  return std::max(1, static_cast<int>(std::lround(5 * std::cbrt(static_cast<double>(elements) / 1777))));
}

}  // namespace forefeel
