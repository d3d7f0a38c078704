#include "geometry/meshing/deviation.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {
namespace {

constexpr double large_volume_change = 0.05;
constexpr double large_hausdorff = 0.05;  // of the longest side

}  // namespace

Deviation deviation_of(const Surface& surface, const TetMesh& mesh, double hausdorff,
                       std::optional<double> length, const RepairReport& repair) {
  Deviation deviation{.hausdorff = hausdorff, .longest_side = longest_side(mesh)};
  const SurfaceSummary sum = summarise(surface);
  const double scale = length ? *length / sum.box.size().maxCoeff() : 1;
  // The file's own volume is wrong where facets are flipped or parts overlap, and then that of the repaired surface is
  // taken.
  const bool flipped =
      repair.reoriented && !repair.wrapped && repair.self_intersections == 0 && repair.holes == 0;
  const double before =
      flipped || repair.united ? repair.volume : std::abs(sum.volume) * scale * scale * scale;
  if (before > 0) deviation.volume_change = mesh_quality(mesh).volume / before - 1;
  return deviation;
}

std::vector<std::string> in_words(const Deviation& deviation, const RepairReport& repair) {
  const std::string what_to_do =
      repair.crossing > 0 && !repair.united
          ? fmt::format("{} parts of the surface cross and could not be united: unite them in a mesh editor",
                        repair.crossing)
      : repair.components > 1
          ? fmt::format(
                "the surface has {} parts, and one inside another may become a cavity: remove the inner ones "
                "in a mesh editor, or try more elements",
                repair.components)
      : repair.wrapped || repair.self_intersections > 0 || repair.holes > 0
          ? "mend the surface in a mesh editor first, or try more elements, which follow it more closely"
          : "more elements follow the surface more closely";
  std::vector<std::string> words;
  if (repair.crossing > 0)
    words.push_back(
        fmt::format("{} parts of the surface cross each other ({} pairs of triangles): {}", repair.crossing,
                    repair.self_intersections,
                    repair.united ? "the body is their union" : "the body was rebuilt around all of them"));
  if (std::abs(deviation.volume_change) > large_volume_change)
    words.push_back(fmt::format(
        "the mesh has {:.0f} % {} volume than the surface{}; {}", 100 * std::abs(deviation.volume_change),
        deviation.volume_change < 0 ? "less" : "more",
        repair.self_intersections > 0 ? ", whose overlapping parts count twice" : "", what_to_do));
  if (deviation.hausdorff > large_hausdorff * deviation.longest_side)
    words.push_back(fmt::format(
        "the mesh is up to {:.3g} mm off the surface, {:.0f} % of its longest side; {}",
        1e3 * deviation.hausdorff, 100 * deviation.hausdorff / deviation.longest_side, what_to_do));
  return words;
}

}  // namespace forefeel
