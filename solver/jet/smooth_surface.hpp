#pragma once
// The smooth surface over which a touch slides: through the nodes of a triangulated surface, of continuous tangent, and
// a function of the place b (barycentric) on a facet:
//   y(b) = sum_v w_v(b) P_v(chi_v(b))      [m], v over the facet's three corners
// chi_v lays the facets around the node v flat: lengths from v as they are, angles scaled so that they fill the turn.
// P_v is the quadratic with P_v(0) = v that fits v's neighbours best, in least squares. The weights w_v blend the
// three with no slope across any edge (below), so y is continuously differentiable across edges and at nodes, whatever
// the shapes of the facets. Manifold surfaces: Grimm and Hughes 1995, Ying and Zorin 2004.
//
// Weights: on edge i with ends j and k, w_j = g(tau_i), tau_i the foot of b on the edge, g(tau) = 1 - 3 tau^2 + 2
// tau^3; inside, the three edges' weights are averaged by 1 / d_i^2, d_i the distance to edge i.
//
// Kept as they are: an edge whose facets meet at more than `feature_angle`, or that is not shared by two facets. Along
// it y is continuous and the tangent plane is not; the edge itself becomes a smooth curve where two such edges meet. A
// node where y would fold, or go farther from a facet than `most_lift` of its longest edge, keeps its flat facets.
// Where the nodes around a facet lie in its plane, y is the facet.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

constexpr double feature_angle = 40 * 0.017453292519943295;  // [rad]
constexpr double most_lift = 0.25;

struct SmoothFacet {
  std::array<std::uint32_t, 3> corners{};
  std::array<std::int32_t, 3> beside{-1, -1, -1};  // across the edges 01, 12, 20; -1: none, or several
};

struct SmoothSpot {
  Vec3 at = Vec3::Zero();      // y [m]
  Vec3 normal = Vec3::Zero();  // of the smooth surface, outward, of length 1
  Mat3 by = Mat3::Identity();  // dy = by t for a way t in the facet's plane; by n = normal, n the facet's
};

class SmoothSurface {
 public:
  SmoothSurface() = default;
  SmoothSurface(std::span<const Vec3> nodes, std::span<const SmoothFacet> facets);

  bool is_flat(std::int32_t facet) const { return facets_[static_cast<std::size_t>(facet)].flat; }
  // Whether edge 01, 12 or 20 of a facet is kept as a feature.
  bool keeps(std::int32_t facet, std::size_t side) const {
    return facets_[static_cast<std::size_t>(facet)].kept[side];
  }
  SmoothSpot at(std::int32_t facet, const Vec3& share) const;   // share: b
  double farthest() const { return farthest_; }                 // of y from the facets, at sampled places [m]
  std::size_t kept_edges() const { return kept_edges_; }        // as features
  std::size_t faceted_nodes() const { return faceted_nodes_; }  // that keep their flat facets

 private:
  // The facets around a node from one kept edge to the next, or all of them.
  struct Fan {
    Vec3 node = Vec3::Zero();
    Eigen::Matrix<double, 3, 2> linear = Eigen::Matrix<double, 3, 2>::Zero();
    Mat3 square = Mat3::Zero();   // columns: of x^2, x y, y^2 [1/m]
    double scale = 1, angle = 0;  // of angles; the whole, scaled
    bool open = false;            // between two kept edges: what takes P there to the curve of the edge,
    std::array<Vec3, 2> kept_linear{Vec3::Zero(), Vec3::Zero()}, kept_square{Vec3::Zero(), Vec3::Zero()};
    bool flat = false;
  };
  struct Corner {
    std::int32_t fan = -1;  // -1: the node keeps its flat facets
    double start = 0;       // angle of the edge to the next corner in the fan
  };
  struct Facet {
    std::array<Vec3, 3> corner{}, edge{};  // edge i: of length 1, from corner i to the next
    std::array<double, 3> length{};
    Vec3 normal = Vec3::Zero();
    std::array<Corner, 3> corners{};
    std::array<bool, 3> kept{};
    bool flat = false;
  };
  struct Walker;

  void find_fans(std::span<const SmoothFacet> facets);
  void fit(Fan& fan, std::span<const Vec3> ends, std::span<const double> angles) const;
  bool is_sound(const Facet& facet, double& lift) const;
  void add_corner(const Facet& facet, std::size_t i, const Vec3& s, Vec3& value, Mat3& by) const;
  SmoothSpot blended(const Facet& facet, const Vec3& share) const;

  std::vector<Facet> facets_;
  std::vector<Fan> fans_;
  double farthest_ = 0;
  std::size_t kept_edges_ = 0, faceted_nodes_ = 0;
};

}  // namespace forefeel
