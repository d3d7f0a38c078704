#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/meshing/graded_fill.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/phantom_bodies.hpp"
#include "geometry/meshing/size_field.hpp"

namespace forefeel {
namespace {

constexpr double share = 0.02;  // of the count, at which the search stops
constexpr int most_tries = 10;

// What is clamped without another wish, as phantom() clamps it.
LowEnd own_clamp(std::string_view name) {
  if (name == "beam") return {Axis::x, 0};
  return {Axis::z, name == "slab" ? 0 : name == "ball" ? 0.2 : 0.25};
}

Surface box_surface(const Box& box) {
  Surface surface;
  for (unsigned i = 0; i < 8; ++i)
    surface.nodes.emplace_back(i & 1 ? box.high.x() : box.low.x(), i & 2 ? box.high.y() : box.low.y(),
                               i & 4 ? box.high.z() : box.low.z());
  surface.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return surface;
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
    CountedFill fill = fill_graded(skin_of(field), field, elements, share);
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
