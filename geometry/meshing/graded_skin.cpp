#include "geometry/meshing/graded_skin.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "geometry/meshing/nearest_point.hpp"
#include "geometry/meshing/surface_process.hpp"

namespace forefeel {
namespace {

constexpr double smooth_turn = 0.5;  // lines may turn by 60 degrees at a node that is no corner

NodeIndex nearest_node(const Surface& surface, const Vec3& point) {
  NodeIndex best = 0;
  for (NodeIndex i = 1; i < surface.nodes.size(); ++i)
    if ((surface.nodes[i] - point).squaredNorm() < (surface.nodes[best] - point).squaredNorm()) best = i;
  return best;
}

void add_corners(GradedInput& input, std::span<const Link> lines, double turn_cosine) {
  const std::vector<NodeIndex> found = corners_of(input.start, lines, turn_cosine);
  input.corners.insert(input.corners.end(), found.begin(), found.end());
}

void pin(GradedInput& input, const Vec3& point) {
  const NodeIndex node = nearest_node(input.start, point);
  input.start.nodes[node] = point;
  input.corners.push_back(node);
}

// turn_cosine: as of corners_of().
void settle(GradedInput& input, double turn_cosine) {
  std::erase_if(input.sharp, [&](const Link& link) { return std::ranges::binary_search(input.rim, link); });
  std::vector<Link> all = input.sharp;
  all.insert(all.end(), input.rim.begin(), input.rim.end());
  add_corners(input, all, turn_cosine);
  // Where a line changes its kind it has an end.
  for (const Link& link : input.sharp)
    for (const NodeIndex node : link)
      if (std::ranges::any_of(input.rim,
                              [&](const Link& other) { return std::ranges::count(other, node) > 0; }))
        input.corners.push_back(node);
  std::ranges::sort(input.corners);
  input.corners.erase(std::unique(input.corners.begin(), input.corners.end()), input.corners.end());
}

// Triangles of the wanted sizes on the surface.
double wanted_triangles(const Surface& surface, const SizeField& size) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 &p = surface.nodes[a], &q = surface.nodes[b], &r = surface.nodes[c];
    const double edge = size.at((p + q + r) / 3);
    sum += (q - p).cross(r - p).norm() / 2 / (std::sqrt(3.0) / 4 * edge * edge);
  }
  return sum;
}

// The ends of the body along an axis. With them as nodes, the mesh has the extent of the surface.
std::vector<Vec3> ends_along(const Surface& surface, Axis axis) {
  const auto k = static_cast<Eigen::Index>(axis);
  const auto [low, high] =
      std::ranges::minmax_element(surface.nodes, [&](const Vec3& a, const Vec3& b) { return a[k] < b[k]; });
  return {*low, *high};
}

}  // namespace

GradedSurface graded_skin(const Surface& closed, const SkinOptions& options, const SizeField& size) {
  GradedInput input{.start = closed, .size = size};
  // Far finer surfaces lose their noise first, as where they are remeshed evenly. Borders of marks would be lost.
  const double far_finer =
      static_cast<double>(closed.triangles.size()) / (6 * wanted_triangles(closed, size));
  if (options.marks.empty() && far_finer > 1) input.start = decimated(closed, 1 / far_finer);
  const auto nearest = nearest_on(closed);
  input.onto = [nearest](const Vec3& p) { return nearest(p).point; };
  for (const Vec3& point : options.pins) pin(input, point);
  if (!options.marks.empty()) {
    input.rim = borders(closed, options.marks);
    input.onto_rim = nearest_on_lines(closed, input.rim);
  }
  if (options.rim) {
    for (const Vec3& end : ends_along(closed, options.rim->axis)) pin(input, end);
    const Axis axis = options.rim->axis;
    const double level = rim_level(bounding_box(closed), *options.rim);
    Surface exact = closed;
    cut_at(exact, axis, level);
    input.onto_rim = nearest_on_lines(exact, borders(exact, marks_below(exact, axis, level)));
    cut_at(input.start, axis, level);
    input.rim = borders(input.start, marks_below(input.start, axis, level));
  }
  if (options.keep_sharp) input.sharp = sharp_edges(input.start);
  input.onto_sharp = nearest_on_lines(input.start, input.sharp);
  // Borders of marks are exact: a mesh is seldom made coarser than the one that they come from.
  settle(input, options.marks.empty() ? smooth_turn : 0.999);
  return graded_surface(input);
}

GradedSurface graded_skin(const SmoothSkin& body, const SizeField& size) {
  GradedInput input{.start = body.start, .onto = body.onto, .size = size};
  for (const Vec3& point : body.pins) pin(input, point);
  cut_at(input.start, body.axis, body.level);
  input.rim = borders(input.start, marks_below(input.start, body.axis, body.level));
  const auto k = static_cast<Eigen::Index>(body.axis);
  input.onto_rim = [&body, k](Vec3 p) {
    p[k] = body.level;
    return body.onto_cut(p, body.axis);
  };
  for (const Link& link : input.rim)
    for (const NodeIndex node : link) input.start.nodes[node] = input.onto_rim(input.start.nodes[node]);
  settle(input, smooth_turn);
  return graded_surface(input);
}

std::optional<GradedSurface> without_intersections(GradedSurface given) {
  if (!intersects_itself(given.surface)) return given;
  RepairReport report;
  GradedSurface mended{repair_surface(given.surface, report), {}, given.onto};
  if (report.wrapped) return std::nullopt;
  const auto place = [](const Vec3& p) { return std::array{p.x(), p.y(), p.z()}; };
  std::set<std::array<double, 3>> held;
  for (std::size_t i = 0; i < given.held.size(); ++i)
    if (given.held[i]) held.insert(place(given.surface.nodes[i]));
  for (const Vec3& node : mended.surface.nodes) mended.held.push_back(held.contains(place(node)));
  return mended;
}

}  // namespace forefeel
