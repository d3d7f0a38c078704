#pragma once
// The reference force of a viscous body in each frame of a run. Tight solves exist only at the samples, but the filter
// (approx/switch/relaxation.hpp) needs the elastic force f [N] in all frames. Between two samples a and b, f is
// interpolated by a cubic Hermite polynomial H of forces and stiffnesses along the chord. The offset d [m] of the HIP
// from the chord is taken into account by the interpolated stiffness:
//   f = H(s) - ((1 - s) K_a + s K_b) d,   H(0) = f_a, H(1) = f_b, H'(0) = -K_a (x_b - x_a), H'(1) = -K_b (x_b - x_a)
// s in [0, 1]: the share of the travel from a to b. Before the first sample and after the last one it is the tangent
// of that sample. Without stiffness: linear between forces. The error is of the fourth order in the distance of the
// samples (reference_step) along a straight path.

#include <cstddef>
#include <span>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "geometry/states/state.hpp"
#include "scheduling/common/records.hpp"

namespace forefeel {

struct SampledState {
  std::size_t frame = 0;  // increasing
  State state = {};       // at the position of that frame, usable
};

// F of each frame [N]; empty if there are no samples.
std::vector<Vec3> viscous_reference(std::span<const FrameRecord> frames,
                                    std::span<const SampledState> samples, const Viscosity& viscosity);

}  // namespace forefeel
