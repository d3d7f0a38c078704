#include "approx/switch/relaxation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace forefeel {

std::string problem_of(const Viscosity& viscosity) {
  double sum = 0;
  for (const MaxwellBranch& branch : viscosity) {
    if (!(branch.share > 0 && branch.share < 1))
      return fmt::format("a share of {}, expected a number between 0 and 1", branch.share);
    if (!(branch.time > 0) || !std::isfinite(branch.time))
      return fmt::format("a time of {}, expected a number above 0 [s]", branch.time);
    sum += branch.share;
  }
  if (sum >= 1) return fmt::format("shares with a sum of {:g}, expected a sum below 1", sum);
  return {};
}

double long_term_share(const Viscosity& viscosity) {
  double left = 1;
  for (const MaxwellBranch& branch : viscosity) left -= branch.share;
  return left;
}

double relaxation(const Viscosity& viscosity, double t) {
  double value = long_term_share(viscosity);
  for (const MaxwellBranch& branch : viscosity) value += branch.share * std::exp(-t / branch.time);
  return value;
}

RelaxationFilter::RelaxationFilter(const Viscosity& viscosity) : long_term_(long_term_share(viscosity)) {
  for (const MaxwellBranch& branch : viscosity)
    branches_.push_back({branch.share, branch.time, 1, 1, Vec3::Zero()});
}

Vec3 RelaxationFilter::step(const Vec3& elastic, double dt) noexcept {
  passed_ += begun_ ? std::max(dt, 0.0) : 0;
  if (!elastic.allFinite()) return elastic;
  if (passed_ != dt_) {
    dt_ = passed_;
    for (Branch& branch : branches_) {
      const double a = dt_ / branch.time;
      branch.decay = std::exp(-a);
      branch.weight = a > 0 ? -std::expm1(-a) / a : 1;
    }
  }
  Vec3 force = long_term_ * elastic;
  for (Branch& branch : branches_) {
    branch.stress = branch.decay * branch.stress + branch.share * branch.weight * (elastic - last_);
    force += branch.stress;
  }
  last_ = elastic;
  passed_ = 0;
  begun_ = true;
  return force;
}

}  // namespace forefeel
