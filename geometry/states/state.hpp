#pragma once
// A state: the static equilibrium of the body with the HIP (haptic interaction point, the tip) at position x [m].
//   f = -dW/dx   force of the body on the HIP [N]      K = -df/dx   stiffness [N/m], k_ij = -df_i/dx_j
//   W = sum V (psi(F) - psi(I))   stored energy [J]
// Values that are not known are NaN: a measured force comes without stiffness.

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct EnergyJet;  // energy_jet.hpp

// Number of a state in its state space: from 0 in order of insertion, without gaps, never reused.
struct StateId {
  std::uint32_t value = 0xffffffffu;
  bool valid() const { return value != 0xffffffffu; }
  friend bool operator==(StateId, StateId) = default;
  friend auto operator<=>(StateId, StateId) = default;
};

enum class SolveStatus : std::uint8_t { converged, diverged, stalled, inverted, cancelled, measured };
std::string_view name(SolveStatus status);
std::optional<SolveStatus> solve_status(std::string_view name);  // the inverse of name()

inline constexpr double largest_number = 1e100;  // of a value in a state; squares must not overflow
inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// How a state was found; of a measured one nothing but the status is known.
struct SolveNote {
  SolveStatus status = SolveStatus::measured;
  bool multivalued = false;  // another path leads to another stable equilibrium here
  int iterations = 0;
  double residual = unknown;              // relative to the force
  double seconds = unknown;               // time of the solve [s]
  double min_jacobian = unknown;          // least det F over the elements
  Vec3 parent = Vec3::Constant(unknown);  // position whose solution the solve started from [m]
};

struct State {
  Vec3 at = Vec3::Zero();                                    // [m]
  Vec3 site = Vec3::Constant(unknown);                       // of a pad anywhere, on the rest surface [m]
  Vec3 force = Vec3::Constant(unknown);                      // [N]
  Mat3 stiffness = Mat3::Constant(unknown);                  // [N/m]
  double energy = unknown;                                   // [J]
  double spacing = unknown;                                  // target spacing of an adaptive lattice here [m]
  std::shared_ptr<const std::vector<double>> displacements;  // #V x 3, row by row [m]; null unless wanted
  std::shared_ptr<const EnergyJet> jet;                      // null unless wanted
  SolveNote solve;

  bool usable() const {
    return solve.status == SolveStatus::converged || solve.status == SolveStatus::measured;
  }
  bool has_stiffness() const { return stiffness.allFinite(); }
  bool has_site() const { return site.allFinite(); }
  Vec3 tip() const { return has_site() ? Vec3(site + at) : at; }  // where the HIP is
};

}  // namespace forefeel
