#pragma once
// Slices through labelled regions in three directions, with states, the outline of a body and a legend. The
// four colours differ in luminance and carry hatching, so they can be told apart in grey print and with
// colour blindness.

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/mesh/tet_mesh.hpp"

namespace forefeel {

struct CoveragePicture {
  Box box;                      // [m]
  Vec3 through = Vec3::Zero();  // the point that the three planes share [m]
  double spacing = 0.006;       // h [m]: states within h/2 of a plane are drawn
  std::vector<Vec3> states;     // [m]
  std::function<Label(const Vec3&)> label;
  std::array<double, 4> volume{};  // [m^3], for the legend
  std::array<std::size_t, 4> components{};
  std::string title;
  std::vector<std::array<Vec3, 3>> body;  // triangles of the outline, in HIP coordinates; may be empty
};

void write_coverage_svg(const std::filesystem::path& file, const CoveragePicture& picture);
// By gnuplot: .png, or .pdf. InputError if it is missing.
void write_coverage_drawn(const std::filesystem::path& file, const CoveragePicture& picture);

}  // namespace forefeel
