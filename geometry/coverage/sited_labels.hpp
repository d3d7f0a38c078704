#pragma once
// Labels where a body is touched anywhere. A state is (s, x): a site on the surface with the normal n there, and the
// displacement x of the tip. The label at (s, x) is that of x among the states whose sites lie within `reach` of s and
// whose normals are within 60 degrees of n, each turned by the least rotation that takes its normal to n. So the
// labels of one place (coverage.hpp) and their theorems serve. The far side of a thin lobe has another normal.

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

struct SitedState {
  Vec3 site = Vec3::Zero(), normal = Vec3::UnitZ(), x = Vec3::Zero();  // [m], of length 1, [m]
};

class SitedLabels {
 public:
  // spaces: spacing and thresholds; its box is replaced by a cube of half-width `depth`, in the frame of a site.
  SitedLabels(std::vector<SitedState> states, StateSpaceOptions spaces, double depth, double reach);

  // Of x among the first `known` states. The space of a site is kept while the next question is about a place within a
  // quarter of `reach` and about as many states. One thread at a time.
  Label at(const SitedState& place, std::size_t known);
  Label at(const SitedState& place) { return at(place, states_.size()); }
  // The states that the last answer came from.
  std::size_t states_near() const { return space_ ? space_->size() : 0; }

 private:
  void gather(const SitedState& place, std::size_t known);

  std::vector<SitedState> states_;
  StateSpaceOptions options_;
  double reach_;
  std::optional<StateSpace> space_;
  std::size_t known_ = 0;
  SitedState middle_;
};

}  // namespace forefeel
