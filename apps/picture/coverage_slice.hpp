#pragma once
// What a picture of coverage shows, and plane cuts through it, sampled for drawing.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "apps/picture/label_image.hpp"
#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"

namespace forefeel {

struct CoveragePicture {
  Box box;                      // [m]
  Vec3 through = Vec3::Zero();  // the point that the three planes share [m]
  double spacing = 0.006;       // h [m]: states within h/2 of a plane are drawn
  std::vector<Vec3> states;     // [m]
  std::function<Label(const Vec3&)> label;
  ByLabel<double> volume{};  // [m^3], for the legend
  ByLabel<std::size_t> components{};
  std::string title;
  std::vector<std::array<Vec3, 3>> body;  // triangles of the outline, in HIP coordinates; may be empty
};

constexpr int slice_panel = 330;  // samples along the longer side, at most

// The plane through picture.through across axis `normal`. States and outline: in samples from its lower left corner.
struct Slice {
  int normal, u, v;  // axes: across, to the right, upwards
  LabelImage labels;
  std::vector<Eigen::Vector2d> states;
  std::vector<std::array<Eigen::Vector2d, 2>> outline;  // inside the slice
  double state_radius = 0;
  bool too_many_states = false;
};

Slice cut(const CoveragePicture& picture, int normal);

}  // namespace forefeel
