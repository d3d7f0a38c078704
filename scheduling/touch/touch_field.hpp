#pragma once
// What a touch needs to know of a body: energy and its derivatives at (s, x), the normal under the pad, the surface.

#include <memory>

#include "solver/sites/site_field.hpp"

namespace forefeel {

struct TouchTerms {
  SiteTerms at;                // E, f, K and dE/ds
  Vec3 normal = Vec3::Zero();  // n(s), the mean normal under the pad
};

class TouchField {
 public:
  virtual ~TouchField() = default;
  virtual TouchTerms at(const SurfacePlace& site, const Vec3& x) const = 0;
  virtual const SurfaceMap& map() const = 0;
};

// A SiteField. Keeps the model of the last site, so that a touch that sticks costs a polynomial; for one thread.
class FieldOfSites : public TouchField {
 public:
  explicit FieldOfSites(std::shared_ptr<const SiteField> field);
  TouchTerms at(const SurfacePlace& site, const Vec3& x) const override;
  const SurfaceMap& map() const override;

 private:
  std::shared_ptr<const SiteField> field_;
  mutable SurfacePlace last_;
  mutable SiteModel model_;
};

}  // namespace forefeel
