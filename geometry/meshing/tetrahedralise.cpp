#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "geometry/common/error.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/meshing/surface_process.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

constexpr double share = 0.05;         // accepted relative deviation of the count
constexpr double close_enough = 0.02;  // deviation at which the search stops

void scale(Surface& surface, double length, const std::string& name) {
  const double side = bounding_box(surface).size().maxCoeff();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError(name, fmt::format("length {} m, expected a positive number", length));
  if (!(side > 0)) throw InputError(name, "has no extent, expected a closed surface");
  for (Vec3& node : surface.nodes) node *= length / side;
}

// Coarse triangles cut off round ends; this scales the mesh back to the wanted length.
void match_length(TetMesh& mesh, double length, const Vec3& centre) {
  const double factor = length / longest_side(mesh);
  for (Vec3& node : mesh.nodes) node = centre + factor * (node - centre);
}

// Edge of the tetrahedra when `elements` of about equal size fill the body; 0.15 l^3 is what a tetrahedron of
// TetGen's takes in the mean (a regular one 0.118 l^3).
double edge_for(const Surface& surface, std::size_t elements) {
  return std::cbrt(enclosed_volume(surface) / (0.15 * static_cast<double>(elements)));
}

bool meets(const std::optional<TetMesh>& mesh, std::size_t elements) {
  return mesh &&
         std::abs(static_cast<double>(mesh->tets.size()) / static_cast<double>(elements) - 1) <= share;
}

class Attempts {
 public:
  Attempts(const Surface& input, Surface closed, const TetrahedraliseOptions& options,
           RepairReport& repair_report)
      : input_(input), closed_(std::move(closed)), options_(options), repair_(repair_report) {}

  TetMesh run() {
    double edge = edge_for(closed_, options_.elements);
    for (int k = 0; k < 14; ++k) {
      CountedFill fill = fill_to_count(skin(edge), options_.elements, close_enough);
      if (meets(fill.mesh, options_.elements)) return std::move(*fill.mesh);
      if (fill.mesh && std::abs(log_ratio(*fill.mesh)) < std::abs(log_ratio_))
        log_ratio_ = log_ratio(*fill.mesh);
      if (!fill.mesh && ++failures_ == 3) wrap();
      problem_ = fill.problem;
      edge *= fill.too_fine ? 1.1 : 0.94;
    }
    throw InputError(options_.name,
                     fmt::format("{} elements cannot be met within 5 %, {}", options_.elements, excuse()));
  }

 private:
  double log_ratio(const TetMesh& mesh) const {
    return std::log(static_cast<double>(mesh.tets.size()) / static_cast<double>(options_.elements));
  }

  // The surface with triangles of the right size, without self-intersections.
  Surface skin(double edge) {
    Surface surface = resample_surface(closed_, edge);
    RepairReport unused;
    return intersects_itself(surface) ? repair_surface(surface, unused) : surface;
  }

  void wrap() {
    if (repair_.wrapped) return;
    closed_ = alpha_wrap(input_, bounding_box(input_).size().norm() / 60);
    repair_.wrapped = true;
  }

  std::string excuse() const {
    if (std::isfinite(log_ratio_))
      return fmt::format("the nearest is {:.0f}",
                         static_cast<double>(options_.elements) * std::exp(log_ratio_));
    return problem_.empty() ? "TetGen gives no mesh" : problem_;
  }

  const Surface& input_;
  Surface closed_;
  const TetrahedraliseOptions& options_;
  RepairReport& repair_;
  double log_ratio_ = std::numeric_limits<double>::infinity();
  int failures_ = 0;
  std::string problem_;
};

TetMesh fill_as_given(const Surface& closed, const std::string& name) {
  std::string problem;
  std::optional<TetMesh> mesh = fill_with_tets(closed, {}, problem);
  if (!mesh) mesh = fill_with_tets(closed, {.keep_surface = false}, problem);
  if (!mesh || mesh->tets.empty())
    throw InputError(name, fmt::format("cannot be filled with tetrahedra: {}", problem));
  return std::move(*mesh);
}

}  // namespace

TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report) {
  if (surface.triangles.empty())
    throw InputError(options.name, "holds no triangles, expected a closed surface");
  Surface input = surface;
  if (options.length) scale(input, *options.length, options.name);
  TetrahedraliseReport local;
  TetrahedraliseReport& out = report ? *report : local;
  out = {};
  TetMesh mesh;
  try {
    const Surface closed = repair_surface(input, out.repair);
    mesh = options.elements == 0 ? fill_as_given(closed, options.name)
                                 : Attempts(input, closed, options, out.repair).run();
  } catch (const InputError& error) {
    if (error.place().key != "surface" || options.name == "surface") throw;
    throw InputError(options.name, error.problem());
  }
  if (options.length) match_length(mesh, *options.length, bounding_box(input).centre());
  if (report) out.hausdorff = hausdorff_distance(input, boundary_surface(mesh));
  return mesh;
}

}  // namespace forefeel
