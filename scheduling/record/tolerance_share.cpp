#include "scheduling/record/tolerance_share.hpp"

#include <cmath>

namespace forefeel {

ToleranceShare tolerance_share(const SessionResult& result, const Tolerance& tolerance) {
  ToleranceShare share;
  for (const FrameRecord& f : result.frames) {
    const bool viscous =
        std::isfinite(f.judged.elastic_reference.x());  // the bars belong to the elastic force
    const Vec3& rendered = viscous ? f.elastic : f.force;
    const bool known = f.bar.half_width[1] <= tolerance.limit(rendered.norm());
    ++share.frames;
    share.frames_known += known ? 1 : 0;
    if (!f.judged.sampled || !std::isfinite(f.judged.error)) continue;
    const Vec3& truth = viscous ? f.judged.elastic_reference : f.judged.reference;
    const bool within = (rendered - truth).norm() <= tolerance.limit(truth.norm());
    ++share.samples;
    share.known += known ? 1 : 0;
    share.within += within ? 1 : 0;
    share.known_true += known && within ? 1 : 0;
  }
  return share;
}

}  // namespace forefeel
