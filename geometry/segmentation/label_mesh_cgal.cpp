#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_map>

#include "geometry/segmentation/label_domain.hpp"
#include "geometry/segmentation/label_mesh.hpp"

namespace forefeel {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace parameters = CGAL::parameters;

Domain domain_of(const LabelDomain& labels) {
  const Box box = labels.box();
  const CGAL::Bbox_3 bounds(box.low.x(), box.low.y(), box.low.z(), box.high.x(), box.high.y(), box.high.z());
  const Domain::Fct function = [&labels](const Kernel::Point_3& p) {
    return labels.at({p.x(), p.y(), p.z()});
  };
  // Interfaces are located to a hundredth of a voxel.
  const double error = 0.01 * labels.smallest_step() / (box.high - box.low).norm();
  return Domain(function, bounds, parameters::relative_error_bound = error);
}

Kernel::Point_3 point(const Vec3& x) {
  return {x.x(), x.y(), x.z()};
}

// Adds the first points on the interfaces. CGAL's own come from the middle of the box and miss small, thin or remote
// parts: refinement never finds a sheet on which no point lies.
class Seeds {
 public:
  Seeds(Complex& complex, const Domain& domain) : complex_(complex), domain_(domain) {}

  // Where the interface crosses the segment between a and b, which have different labels.
  void add(const Vec3& a, const Vec3& b) {
    const auto hit = domain_.construct_intersection_object()(Kernel::Segment_3(point(a), point(b)));
    if (std::get<2>(hit) < 2) return;
    const auto vertex = complex_.triangulation().insert(Triangulation::Weighted_point(std::get<0>(hit)));
    if (vertex == Triangulation::Vertex_handle()) return;
    complex_.set_dimension(vertex, std::get<2>(hit));
    complex_.set_index(vertex, std::get<1>(hit));
  }

 private:
  Complex& complex_;
  const Domain& domain_;
};

// Rays start inside each part and end where its label ends. Between them, interfaces get points that are twice as far
// apart as the nodes of the mesh will be.
void seed(Complex& complex, const Domain& domain, const LabelDomain& labels, double cell) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Seeds seeds(complex, domain);
  const double step = 0.5 * labels.smallest_step();
  for (const LabelDomain::Part& part : labels.seeded())
    for (int ray = 0; ray < 24; ++ray) {
      const double x = normal(random), y = normal(random), z = normal(random);
      const Vec3 along = step * Vec3(x, y, z).normalized();
      Vec3 last = part.at, next = last + along;
      while (labels.at(next) == part.subdomain) last = next, next += along;
      seeds.add(last, next);
    }
  for (const auto& [inside, outside] : labels.across_interfaces(2 * cell)) seeds.add(inside, outside);
}

// cell: circumradius of tetrahedra at most [m]. Triangles of the interfaces have the same bound, and stay within a
// fourteenth of it of the interface.
Complex mesh_with(const Domain& domain, const LabelDomain& labels, double cell) {
  Complex complex;
  seed(complex, domain, labels, cell);
  const Criteria criteria(parameters::facet_angle = 25, parameters::facet_size = cell,
                          parameters::facet_distance = 0.07 * cell, parameters::cell_radius_edge_ratio = 2,
                          parameters::cell_size = cell);
  CGAL::refine_mesh_3(complex, domain, criteria, parameters::no_exude(), parameters::no_perturb(),
                      parameters::no_odt(), parameters::no_lloyd(), parameters::no_reset_c3t3());
  return complex;
}

// Finds the size for a number of tetrahedra. The number is about proportional to size^-3, so secant steps between
// logarithms lead there; where it jumps, as parts get lost or found, the interval between sizes on both sides is
// halved.
class SizeSearch {
 public:
  SizeSearch(const Domain& domain, const LabelDomain& labels, LabelTold& told)
      : domain_(domain), labels_(labels), told_(told) {}

  Complex run(std::size_t elements) {
    constexpr double near = 0.02, narrow = 1e-3;
    constexpr int most_meshes = 14;
    const double wanted = std::log(static_cast<double>(elements));
    double size =
        std::log(1.05 * std::cbrt(labels_.volume_of_body() / (0.12 * static_cast<double>(elements))));
    Complex best;
    double best_error = INFINITY, slope = -2.8, last_size = 0, last_error = 0;
    for (int k = 0; k < most_meshes; ++k) {
      Complex mesh = mesh_with(domain_, labels_, std::exp(size));
      told_.meshes = k + 1;
      const double error =
          std::log(std::max(1.0, static_cast<double>(mesh.number_of_cells_in_complex()))) - wanted;
      if (std::abs(error) < best_error) best_error = std::abs(error), best.swap(mesh);
      if (best_error < near || std::abs(too_coarse_ - too_fine_) < narrow) break;
      (error > 0 ? too_fine_ : too_coarse_) = size;
      if (k > 0 && std::abs(size - last_size) > 1e-6)
        slope = std::clamp((error - last_error) / (size - last_size), -6.0, -1.2);
      last_size = size, last_error = error;
      size = within(size + std::clamp(-error / slope, -0.7, 0.7));
    }
    return best;
  }

 private:
  // The size, or the middle between the known sizes if it does not lie well between them.
  double within(double size) const {
    if (!std::isfinite(too_coarse_ - too_fine_)) return size;
    const double margin = 0.1 * std::abs(too_coarse_ - too_fine_);
    const double low = std::min(too_fine_, too_coarse_), high = std::max(too_fine_, too_coarse_);
    return size > low + margin && size < high - margin ? size : 0.5 * (low + high);
  }

  const Domain& domain_;
  const LabelDomain& labels_;
  LabelTold& told_;
  double too_fine_ = -INFINITY, too_coarse_ = INFINITY;  // log of sizes with too many and too few tetrahedra
};

LabelledTets tets_of(const Complex& complex) {
  LabelledTets result;
  std::unordered_map<const void*, NodeIndex> number;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet{};
    for (unsigned i = 0; i < 4; ++i) {
      const auto vertex = cell->vertex(static_cast<int>(i));
      const auto [at, is_new] = number.emplace(&*vertex, static_cast<NodeIndex>(result.nodes.size()));
      if (is_new) {
        const auto& p = vertex->point().point();
        result.nodes.emplace_back(p.x(), p.y(), p.z());
      }
      tet[i] = at->second;
    }
    result.tets.push_back(tet);
    result.subdomain.push_back(complex.subdomain_index(cell));
  }
  return result;
}

}  // namespace

LabelledTets mesh_domain(const LabelDomain& labels, std::size_t elements, double seconds, LabelTold& told) {
  const Domain domain = domain_of(labels);
  Complex complex = SizeSearch(domain, labels, told).run(elements);
  constexpr double sliver = 12;  // [deg]
  told.step = static_cast<int>(LabelMeshStep::perturb);
  CGAL::perturb_mesh_3(complex, domain, parameters::sliver_bound = sliver, parameters::time_limit = seconds);
  told.step = static_cast<int>(LabelMeshStep::exude);
  CGAL::exude_mesh_3(complex, parameters::sliver_bound = sliver, parameters::time_limit = seconds);
  return tets_of(complex);
}

}  // namespace forefeel
