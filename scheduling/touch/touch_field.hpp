#pragma once
// What a touch needs to know of a body: energy and its derivatives at (s, x), the normal under the pad, the surface.
//
// Beyond R = `farthest` from the site, where no state is, E goes on in a straight line: with r = |x|, n = x / r and
// y = R n
//   E(x) = E(y) - (r - R) n . f(y),   f(x) = f(y) - (r - R) R / r (K(y) n - n (n . K(y) n))
// so the force along x is held, and E stays a potential.

#include <memory>

#include "solver/jet/deep_states.hpp"
#include "solver/jet/field_patches.hpp"
#include "solver/jet/site_field.hpp"
#include "solver/jet/surface_grid.hpp"

namespace forefeel {

struct TouchTerms {
  SiteTerms at;                // E, f, K and dE/ds
  Vec3 normal = Vec3::Zero();  // n(s), the mean normal under the pad
  Vec3 across = Vec3::Zero();  // normal of the smooth surface at s
};

class TouchField {
 public:
  virtual ~TouchField() = default;
  // stiff: K is wanted, and not only near to what it is.
  virtual TouchTerms at(const SurfacePlace& site, const Vec3& x, bool stiff) const = 0;
  TouchTerms at(const SurfacePlace& site, const Vec3& x) const { return at(site, x, true); }
  virtual const SurfaceMap& map() const = 0;
  virtual const SurfaceGrid& grid() const = 0;
};

double reach_of(double depth);     // of the farthest state from its site, for states to this depth [m]
double farthest_of(double depth);  // R [m]: half as far again

// A field of sites with states that correct it, for one thread. Where the facet has a patch it answers from that, in a
// few microseconds and without allocation; else from the field itself, whose cost is hundreds.
class FieldOfSites : public TouchField {
 public:
  // farthest: R [m]. patches: made by another thread; null: none.
  FieldOfSites(std::shared_ptr<const SiteField> field, std::shared_ptr<const SurfaceGrid> grid,
               double farthest, std::shared_ptr<const FieldPatches> patches = {});
  using TouchField::at;
  TouchTerms at(const SurfacePlace& site, const Vec3& x, bool stiff) const override;
  // Of the error of the force [N]; infinite beyond R.
  double estimate(const SurfacePlace& site, const Vec3& x) const;
  void use(const DeepStates* deep) {
    deep_ = deep;
  }  // states that correct the field; null: none. It stays alive.
  const SurfaceMap& map() const override;
  const SurfaceGrid& grid() const override { return *grid_; }

 private:
  const SiteModel& model(const SurfacePlace& site) const;
  SiteTerms terms(const SurfacePlace& site, const Vec3& x, bool stiff) const;

  std::shared_ptr<const SiteField> field_;
  std::shared_ptr<const SurfaceGrid> grid_;
  std::shared_ptr<const FieldPatches> patches_;
  double farthest_;
  const DeepStates* deep_ = nullptr;
  mutable SurfacePlace last_;
  mutable SiteModel model_;
  mutable bool has_root_ = false;
};

}  // namespace forefeel
