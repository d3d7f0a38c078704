#include "scheduling/judge/viscous_reference.hpp"

#include <algorithm>

namespace forefeel {
namespace {

Mat3 stiffness_of(const State& state) {
  return state.has_stiffness() ? state.stiffness : Mat3::Zero();
}

Vec3 tangent(const State& state, const Vec3& x) {
  return state.force - stiffness_of(state) * (x - state.at);
}

Vec3 between(const State& a, const State& b, double s, const Vec3& x) {
  const Vec3 chord = b.at - a.at, off = x - (a.at + s * chord);
  if (!a.has_stiffness() || !b.has_stiffness()) return (1 - s) * a.force + s * b.force;
  const Vec3 from = -(a.stiffness * chord), to = -(b.stiffness * chord);
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * a.force + s * s * (1 + 2 * r) * b.force + s * r * r * from - s * s * r * to -
         (r * a.stiffness + s * b.stiffness) * off;
}

}  // namespace

std::vector<Vec3> viscous_reference(std::span<const FrameRecord> frames,
                                    std::span<const SampledState> samples, const Viscosity& viscosity) {
  if (samples.empty()) return {};
  std::vector<double> travel(frames.size(), 0);
  for (std::size_t k = 1; k < frames.size(); ++k)
    travel[k] = travel[k - 1] + (frames[k].at - frames[k - 1].at).norm();
  RelaxationFilter filter(viscosity);
  std::vector<Vec3> forces;
  std::size_t next = 0;  // the first sample at or after the frame
  for (std::size_t k = 0; k < frames.size(); ++k) {
    while (next < samples.size() && samples[next].frame < k) ++next;
    const Vec3& x = frames[k].at;
    Vec3 elastic;
    if (next == 0 || next == samples.size()) {
      elastic = tangent(samples[std::min(next, samples.size() - 1)].state, x);
    } else {
      const SampledState &a = samples[next - 1], &b = samples[next];
      const double whole = travel[b.frame] - travel[a.frame];
      elastic = between(a.state, b.state, whole > 0 ? (travel[k] - travel[a.frame]) / whole : 1, x);
    }
    forces.push_back(filter.step(elastic, k > 0 ? frames[k].t - frames[k - 1].t : 0));
  }
  return forces;
}

}  // namespace forefeel
