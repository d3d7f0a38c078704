#pragma once
// The worst moments of a session, each with an explanation: where the tip was, which states were known near it, which
// part of the error was largest, and whether the missing state arrived later.

#include <string>
#include <vector>

#include "apps/session/run_view.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct BadMoment {
  double t = 0;            // [s]
  Vec3 at = Vec3::Zero();  // of the tip [m]
  Label label = Label::blank;
  double rendered = 0, reference = 0;  // |force| [N]
  double error = 0, jnds = 0;          // relative; in just noticeable differences
  std::string why;                     // a few short sentences
};

// Samples with an error above the just noticeable difference, the worst first, at least a quarter of a second
// apart, at most `most`.
std::vector<BadMoment> bad_moments(const SessionResult& result, const RunView& view, std::size_t most = 8);

}  // namespace forefeel
