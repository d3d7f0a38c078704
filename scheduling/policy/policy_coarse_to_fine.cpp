// Coarse lattice points far around the predicted path, fine ones near it. With d the distance to the path the
// priority is
//   s / (s + d),    s = 4 h for lattice points at multiples of 4 h, 2 h at multiples of 2 h, h elsewhere

#include <cmath>

#include "scheduling/policy/policies.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {
namespace {

double level_spacing(const Vec3& at, double h) {
  long all = 0;
  for (int i = 0; i < 3; ++i) all |= std::lround(at[i] / h);
  if ((all & 3) == 0) return 4 * h;
  return (all & 1) == 0 ? 2 * h : h;
}

class CoarseToFine final : public Policy {
 public:
  std::string_view name() const override { return "coarse-to-fine"; }
  bool reads_regions() const override { return false; }
  double at_most(double priority) const override { return priority; }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    const double s = level_spacing(candidate.at, view.space.options().spacing);
    return s / (s + distance_to_path(candidate.at, view));
  }
};

}  // namespace

std::unique_ptr<Policy> make_coarse_to_fine(FactoryContext&) {
  return std::make_unique<CoarseToFine>();
}

}  // namespace forefeel
