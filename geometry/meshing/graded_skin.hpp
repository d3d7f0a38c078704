#pragma once
// Surfaces with triangles graded toward a contact, and with edges along the clamp's rim (graded_surface.hpp). Private
// to this room.

#include <functional>
#include <optional>
#include <span>

#include "geometry/meshing/graded_surface.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

// Of a repaired surface: its sharp edges, the rim (low end), the borders between marks and the pins are kept.
struct SkinOptions {
  std::optional<LowEnd> rim = {};
  std::span<const int> marks = {};  // by triangle of the surface; empty: none
  std::span<const Vec3> pins = {};  // [m]; the node nearest to each is moved onto it
  bool keep_sharp = true;           // edges of more than 50 degrees
};
GradedSurface graded_skin(const Surface& closed, const SkinOptions& options, const SizeField& size);

// Of a smooth body about which everything is known.
struct SmoothSkin {
  Surface start;                                    // nodes on the surface
  std::function<Vec3(const Vec3&)> onto;            // the surface
  std::function<Vec3(const Vec3&, Axis)> onto_cut;  // the surface, with the coordinate of that axis as it is
  Axis axis = Axis::z;                              // of the rim
  double level = 0;                                 // of the rim [m]
  std::vector<Vec3> pins = {};                      // [m]
};
GradedSurface graded_skin(const SmoothSkin& body, const SizeField& size);

// Without self-intersections, by local repair; what it replaces is no longer held. Nothing where that fails.
std::optional<GradedSurface> without_intersections(GradedSurface surface);

}  // namespace forefeel
