#pragma once
// Measures how well the force at a place q is known. In the Delaunay triangulation of the known states, q lies in a
// finite cell with circumcentre c and circumradius R:
//   spread    pi(q) = sqrt(R^2 - |q - c|^2)      [m]  infinite outside the hull; factor of Waldron's bound
//             (1998) on the error of linear interpolation
//   distance  delta(q) to the nearest state      [m]
//   cone      gamma(q, rho): half-angle of the largest cone of directions from q that holds no state within
//             rho
// The label is the coverage class of q: the first of safe, sparse, gap, blank whose condition holds (thresholds below).
// Safe means densely known; it says nothing of stability. A gap lies between known regions (it is not a contact gap);
// blank is beyond them. Sparse only needs a near state, so a sparse place may lie outside the hull, with infinite
// spread.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

class AdaptiveLattice;

inline constexpr double threshold_slack = 1e-9;  // relative tolerance of the thresholds of labels

enum class Label : std::uint8_t { safe, sparse, gap, blank };
std::string_view name(Label label);
inline constexpr std::array all_labels{Label::safe, Label::sparse, Label::gap, Label::blank};

// One value for each label.
template <class Value>
struct ByLabel {
  std::array<Value, all_labels.size()> values{};
  Value& operator[](std::size_t label) { return values[label]; }
  const Value& operator[](std::size_t label) const { return values[label]; }
  Value& operator[](Label label) { return values[static_cast<std::size_t>(label)]; }
  const Value& operator[](Label label) const { return values[static_cast<std::size_t>(label)]; }
  auto begin() const { return values.begin(); }
  auto end() const { return values.end(); }
  friend bool operator==(const ByLabel&, const ByLabel&) = default;
};

struct CoverageOptions {
  double safe_spread = 0.95;       // kappa_s: safe needs pi <= kappa_s h
  double safe_cone_radius = 1.45;  // safe also needs gamma(q, safe_cone_radius h) < safe_angle_deg
  double safe_angle_deg = 90;
  double sparse_distance = 1.5;  // kappa_p: sparse needs delta <= kappa_p h
  double gap_cone_radius = 8;    // gap needs gamma(q, 8 h) <= gap_angle_deg
  double gap_angle_deg = 85;
};

struct Coverage {
  Label label = Label::blank;
  double spread = std::numeric_limits<double>::infinity();  // pi [m]
  // alpha: least circumradius over the cells that contain q [m]
  double alpha = std::numeric_limits<double>::infinity();
  double delta = std::numeric_limits<double>::infinity();       // [m]
  double gamma_deg = std::numeric_limits<double>::quiet_NaN();  // gamma(q, 8 h); NaN if no test needed it
};

enum class Design : std::uint8_t;  // design.hpp

// Spacing, box and the thresholds of the labels.
struct StateSpaceOptions {
  double spacing = 0.006;  // h [m]
  Box box{};               // where states are placed [m]; the HIP may leave it
  Design design{};         // how they are placed there; the lattice
  std::shared_ptr<const std::vector<Vec3>> listed =
      nullptr;  // the places of Design::listed [m], in their order
  CoverageOptions coverage{};
  double merge_distance = 1e-9;  // states nearer than this count as one [spacings]
  // If given, labels use its h(q) instead of `spacing`, which then sets only the side of the finest regions
  // (spacing / 4) and the merge distance. Shared, never changed.
  std::shared_ptr<const AdaptiveLattice> lattice = nullptr;
};

// InputError for a spacing that is not a positive length, and for a sparse distance below the safe spread.
void check_options(const StateSpaceOptions& options);

}  // namespace forefeel
