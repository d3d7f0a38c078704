#include "scheduling/judge/patience.hpp"

#include <algorithm>

namespace forefeel {

std::optional<State> Patience::wait_for(const Vec3& at, ReferenceService& references, bool interrupted,
                                        const SurfacePlace& site) {
  for (;;) {
    const auto now = Time::now();
    if (end_ == Time::time_point::max() && (interrupted || stop_.is_interrupted()))
      end_ = now + std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(stop_.patience));
    if (end_ != Time::time_point::max() && stop_.is_hurried()) end_ = std::min(end_, now);
    const auto turn = std::min(end_, now + std::chrono::milliseconds(100));
    std::optional<State> reference = references.get_until(at, turn, site);
    if (reference || turn == end_) return reference;
  }
}

}  // namespace forefeel
