#include "geometry/meshing/phantom.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/meshing/box_mesh.hpp"
#include "geometry/meshing/graded_fill.hpp"
#include "geometry/meshing/relax.hpp"
#include "geometry/meshing/size_field.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

// ---- the bodies

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

// Before it is scaled to its length of 22 cm.
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

// Farthest point of a smooth body along a direction, by ascent along the surface.
Vec3 extreme(const ImplicitSurface& body, const Vec3& direction) {
  Vec3 point = last_crossing(body, body.centre, direction);
  for (int k = 0; k < 200; ++k) {
    const Vec3 normal = body.gradient(point).normalized();
    point = project_onto(body, point + 0.02 * (direction - normal.dot(direction) * normal));
  }
  return point;
}

// The body scaled to its length, and the points that every triangulation of it holds.
struct Liver {
  ImplicitSurface unscaled = liver_body();
  Vec3 left = extreme(unscaled, -Vec3::UnitX()), right = extreme(unscaled, Vec3::UnitX());
  Vec3 top;  // above the thickest place
  double scale = 0.22 / (right.x() - left.x());

  Liver();
  Surface surface(int n) const;  // of 20 n^2 triangles
};

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

struct Blueprint {
  std::string_view name;
  std::size_t elements;  // default
  Vec3 tip;
};

const std::array<Blueprint, 4>& blueprints() {
  static const std::array<Blueprint, 4> all{
      Blueprint{"liver", 1777, liver().scale * liver().top}, Blueprint{"beam", 1920, {0.1, 0.01, 0.01}},
      Blueprint{"ball", 2000, {0, 0, 0.05}}, Blueprint{"slab", 3000, {0, 0, 0.04}}};
  return all;
}

// Of a phantom that is one.
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

// Of the slab: element group "lump", 18 mm below the tip.
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

// Radius of the group "contact" [m].
double phantom_patch(std::string_view name) {
  return name == "beam" ? 0.01 : 0.02;
}

// Of liver and ball: 20 n^2 triangles.
Surface smooth_surface(std::string_view name, int n) {
  if (name == "ball") {
    Surface sphere = geodesic_sphere(n);
    for (Vec3& node : sphere.nodes) node *= 0.05;
    return sphere;
  }
  return liver().surface(n);
}

// The subdivision n whose triangles are about as large as the faces of `elements` equal tetrahedra in the body.
int frequency_for(std::size_t elements) {
  return std::max(1, static_cast<int>(std::lround(5 * std::cbrt(static_cast<double>(elements) / 1777))));
}

// ---- even meshes

TetMesh smooth_mesh(std::string_view name, std::size_t elements) {
  std::string problem;
  for (int n = frequency_for(elements); n >= 1; --n) {
    CountedFill fill = fill_to_count(smooth_surface(name, n), elements, 0.02);
    if (fill.mesh && within_share(fill.mesh->tets.size(), elements)) return std::move(*fill.mesh);
    problem = fill.problem;
    if (!fill.mesh) break;
  }
  throw InputError("phantom", fmt::format("{} elements cannot be met within 5 %{}{}", elements,
                                          problem.empty() ? "" : ": ", problem));
}

// The clamp: beam at its root, ball and slab below, liver on its underside.
std::vector<NodeIndex> clamp_nodes(std::string_view name, const TetMesh& mesh) {
  if (name == "beam") return nodes_below(mesh, Axis::x, 1e-9);
  if (name == "slab") return nodes_below(mesh, Axis::z, 1e-9);
  std::vector<NodeIndex> result, surface = surface_nodes(mesh);
  for (const NodeIndex node : nodes_below(mesh, Axis::z, name == "ball" ? 0.2 : 0.25))
    if (std::ranges::binary_search(surface, node)) result.push_back(node);
  return result;
}

}  // namespace

Surface phantom_surface(std::string_view name) {
  const Blueprint& known = blueprint(name);
  if (!is_box(name)) return smooth_surface(name, frequency_for(known.elements));
  const TetMesh mesh = box_mesh(box_of(name), cells_for(box_of(name).size(), known.elements));
  return boundary_surface(mesh);
}

TetMesh phantom(std::string_view name, std::size_t elements) {
  const Blueprint& known = blueprint(name);
  if (elements == 0) elements = known.elements;
  TetMesh mesh = is_box(name) ? box_mesh(box_of(name), cells_for(box_of(name).size(), elements))
                              : smooth_mesh(name, elements);
  mesh.groups["clamp"] = clamp_nodes(name, mesh);
  auto& contact = mesh.groups["contact"];
  contact = surface_nodes_within(mesh, known.tip, phantom_patch(name));
  if (contact.empty()) contact = {nearest_surface_node(mesh, known.tip)};  // a mesh coarser than the patch
  mark_lump(name, mesh);
  return mesh;
}

std::vector<std::string> phantom_names() {
  return blueprint_names();
}

Vec3 phantom_tip(std::string_view name) {
  return blueprint(name).tip;
}

// ---- graded meshes

namespace {

constexpr double count_share = 0.02;  // at which the search stops
constexpr int most_tries = 10;

// What is clamped without another wish, as phantom() clamps it.
LowEnd own_clamp(std::string_view name) {
  if (name == "beam") return {Axis::x, 0};
  return {Axis::z, name == "slab" ? 0 : name == "ball" ? 0.2 : 0.25};
}

// A smooth phantom in metres: its implicit surface is that of `unscaled` at the scale.
struct SmoothBody {
  ImplicitSurface unscaled;
  double scale = 1;
  std::vector<Vec3> pins;  // [m]

  Vec3 onto(const Vec3& p) const { return scale * project_onto(unscaled, p / scale); }
  // Along the gradient within the plane.
  Vec3 onto_cut(const Vec3& p, Axis axis) const {
    const auto k = static_cast<Eigen::Index>(axis);
    Vec3 q = p / scale;
    for (int step = 0; step < 30; ++step) {
      Vec3 gradient = unscaled.gradient(q);
      gradient[k] = 0;
      const double squared = gradient.squaredNorm();
      if (!(squared > 0)) break;
      const Vec3 move = unscaled.value(q) / squared * gradient;
      q -= move;
      if (move.squaredNorm() < 1e-24 * unscaled.reach * unscaled.reach) break;
    }
    Vec3 result = scale * q;
    result[k] = p[k];
    return result;
  }
  Vec3 end(const Vec3& direction) const { return scale * extreme(unscaled, direction); }
};

SmoothBody smooth_body(std::string_view name) {
  if (name == "liver")
    return {liver_body(),
            liver().scale,
            {liver().scale * liver().top, liver().scale * liver().left, liver().scale * liver().right}};
  return {{[](const Vec3& p) { return 1 - p.squaredNorm(); }, [](const Vec3& p) -> Vec3 { return -2 * p; },
           Vec3::Zero(), 2},
          0.05,
          {phantom_tip(name)}};
}

struct Filled {
  TetMesh mesh;
  SizeField size = {};
  double level = 0;  // of the rim [m]
};

// Coarser or finer surfaces until the count is met.
template <class Skin>
Filled fill_with(const Skin& skin_of, SizeField field, std::size_t elements) {
  std::string problem;
  for (int k = 0; k < most_tries; ++k) {
    CountedFill fill = fill_graded(skin_of(field), field, elements, count_share);
    if (fill.mesh && within_share(fill.mesh->tets.size(), elements))
      return {.mesh = std::move(*fill.mesh), .size = field};
    problem = fill.problem;
    const double factor = fill.too_fine ? 1.1 : 0.94;
    field.near *= factor, field.far *= factor;
  }
  throw InputError("phantom", fmt::format("{} graded elements cannot be met within 5 %{}{}", elements,
                                          problem.empty() ? "" : ": ", problem));
}

Filled smooth_fill(std::string_view name, const PhantomOptions& options, const LowEnd& rim) {
  const SmoothBody body = smooth_body(name);
  SmoothSkin skin{.start = smooth_surface(name, frequency_for(options.elements) + 3),
                  .onto = [&](const Vec3& p) { return body.onto(p); },
                  .onto_cut = [&](const Vec3& p, Axis axis) { return body.onto_cut(p, axis); },
                  .axis = rim.axis,
                  .pins = body.pins};
  Toward toward = options.toward;
  toward.site = body.onto(nearest_point(skin.start, toward.site));
  const SizeField field = size_field(skin.start, toward, options.elements);
  const auto k = static_cast<Eigen::Index>(rim.axis);
  const Vec3 low = body.end(-Vec3::Unit(k)), high = body.end(Vec3::Unit(k));
  skin.level = low[k] + rim.share * (high[k] - low[k]);
  // Ends along the rim's axis are nodes, unless one of the pins is so near that a sliver would lie between them.
  for (const Vec3& end : {low, high})
    if (std::ranges::none_of(skin.pins,
                             [&](const Vec3& pin) { return (pin - end).norm() < 0.5 * field.at(end); }))
      skin.pins.push_back(end);
  Filled filled =
      fill_with([&](const SizeField& size) { return graded_skin(skin, size); }, field, options.elements);
  filled.level = skin.level;
  return filled;
}

Filled box_fill(std::string_view name, const PhantomOptions& options, const LowEnd& rim) {
  const Surface surface = box_surface(box_of(name));
  Toward toward = options.toward;
  toward.site = nearest_point(surface, toward.site);
  const SizeField field = size_field(surface, toward, options.elements);
  const auto skin_of = [&](const SizeField& size) { return graded_skin(surface, {.rim = rim}, size); };
  Filled filled = fill_with(skin_of, field, options.elements);
  filled.level = rim_level(box_of(name), rim);
  return filled;
}

}  // namespace

TetMesh graded_phantom(std::string_view name, const PhantomOptions& asked, SizeField* made) {
  PhantomOptions options = asked;
  if (options.elements == 0) options.elements = blueprint(name).elements;
  if (!(options.toward.radius > 0) || !std::isfinite(options.toward.radius))
    throw InputError("phantom", fmt::format("radius of the contact {} m, expected a positive number",
                                            options.toward.radius));
  const LowEnd rim = options.rim.value_or(own_clamp(name));
  Filled filled = is_box(name) ? box_fill(name, options, rim) : smooth_fill(name, options, rim);
  if (made) *made = filled.size;
  TetMesh& mesh = filled.mesh;
  const std::vector<NodeIndex> surface = surface_nodes(mesh);
  const auto k = static_cast<Eigen::Index>(rim.axis);
  const double limit = filled.level + 1e-9 * longest_side(mesh);
  for (const NodeIndex node : surface)
    if (mesh.nodes[node][k] <= limit) mesh.groups["clamp"].push_back(node);
  auto& contact = mesh.groups["contact"];
  contact = surface_nodes_within(mesh, blueprint(name).tip, phantom_patch(name));
  if (contact.empty()) contact = {nearest_surface_node(mesh, blueprint(name).tip)};
  mark_lump(name, mesh);
  return std::move(mesh);
}

}  // namespace forefeel
