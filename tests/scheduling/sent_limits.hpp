#pragma once
// The force that a device got, against the limits of safety by the wall clock.

#include "scheduling/session/session.hpp"
#include "tests/support/test.hpp"

namespace forefeel::test {

struct SentForce {
  double t;  // when its frame began, by the wall clock of the session [s]
  Vec3 force;
};

inline std::vector<SentForce> sent_forces(const SessionResult& result) {
  std::vector<SentForce> sent;
  for (const FrameRecord& f : result.frames) {
    const double late = std::isfinite(f.timing.lateness_us) ? 1e-6 * f.timing.lateness_us : 0;
    sent.push_back({f.t + late, f.sent});
  }
  return sent;
}

// Finite, inside the force limit, and inside the slew limit for every pair of forces up to 20 frames apart. From one
// frame to the next no more than an ordinary frame allows, however long the pause between them was.
inline void check_sent(const SessionResult& result, const SafetyOptions& limits, double frame = 1e-3) {
  const std::vector<SentForce> sent = sent_forces(result);
  double strongest = 0, fastest = -1, step = 0;
  bool finite = true;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    finite = finite && sent[i].force.allFinite();
    strongest = std::max(strongest, sent[i].force.norm());
    if (i > 0) step = std::max(step, (sent[i].force - sent[i - 1].force).norm());
    for (std::size_t k = i + 1; k < std::min(sent.size(), i + 20); ++k)
      fastest = std::max(
          fastest, (sent[k].force - sent[i].force).norm() - limits.slew_limit * (sent[k].t - sent[i].t));
  }
  CHECK(finite);
  CHECK(strongest <= limits.force_limit * (1 + 1e-12));
  CHECK(fastest <= 1e-6);
  CHECK(step <= limits.slew_limit * frame * (1 + 1e-9));
  REQUIRE_FALSE(sent.empty());
  CHECK(sent.back().force == Vec3::Zero());
}

}  // namespace forefeel::test
