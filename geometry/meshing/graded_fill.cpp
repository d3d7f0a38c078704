#include "geometry/meshing/graded_fill.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/meshing/nearest_point.hpp"

namespace forefeel {

bool is_graded(const TetrahedraliseOptions& options) {
  return options.toward || options.rim || !options.marks.empty() || !options.pins.empty();
}

SizeField size_field_of(const Surface& closed, const TetrahedraliseOptions& options) {
  if (!options.toward) {
    const double edge = uniform_edge(closed, options.elements);
    return {.near = edge, .far = edge};
  }
  Toward toward = *options.toward;
  if (!(toward.radius > 0) || !std::isfinite(toward.radius))
    throw InputError(options.name,
                     fmt::format("radius of the contact {} m, expected a positive number", toward.radius));
  toward.site = nearest_point(closed, toward.site);
  return size_field(closed, toward, options.elements);
}

std::vector<int> marks_on(const Surface& repaired, const Surface& input, std::span<const int> marks) {
  std::vector<int> result;
  if (marks.empty()) return result;
  const auto nearest = nearest_on(input);
  for (const auto& [a, b, c] : repaired.triangles)
    result.push_back(
        marks[nearest((repaired.nodes[a] + repaired.nodes[b] + repaired.nodes[c]) / 3).triangle]);
  return result;
}

CountedFill fill_graded(const GradedSurface& skin, const SizeField& size, std::size_t elements, double share,
                        TetFillOptions options) {
  options.size = [size](const Vec3& point) { return size.at(point); };
  options.held = skin.held;
  options.onto = skin.onto;
  return fill_to_count(skin.surface, elements, share, std::move(options));
}

}  // namespace forefeel
