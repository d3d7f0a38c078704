#pragma once
// The stiffness at rest under a pad at any site of the surface, from the body without a contact:
//   K(s) = t I - m^T C (I + M C)^{-1} m     [N/m]
// M [N/m] springs of the pad at s between free nodes, m = M's row sums and what clamped nodes take, t = int a dA; C
// [m/N] compliance of the body between these nodes: their part of the inverse of d2W/du2. It equals R^T M (I + C
// M)^{-1}
// R with R the rigid translation and C zero at clamped nodes. A column of C costs one solve with the body's factor and
// is kept, so that sites near those known cost a dense system of the pad's nodes alone.

#include <cstddef>
#include <memory>

#include "solver/body/body.hpp"

namespace forefeel {

class SiteStiffness {
 public:
  // body.pad gives radius and stiffness of the pad at every site; its fine body does not count. InputError without a
  // pad, and if the body is not stable at rest.
  explicit SiteStiffness(Body body);
  ~SiteStiffness();
  SiteStiffness(SiteStiffness&&) noexcept;

  Mat3 at(const Vec3& site);  // of the surface [m]; zero where no facet is under the pad
  std::size_t known_nodes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
