#include "scheduling/touch/touch_field.hpp"

#include <cmath>
#include <limits>

namespace forefeel {

double reach_of(double depth) {
  return std::hypot(depth, 0.5 * depth);
}

double farthest_of(double depth) {
  return 1.5 * reach_of(depth);
}

FieldOfSites::FieldOfSites(std::shared_ptr<const SiteField> field, std::shared_ptr<const SurfaceGrid> grid,
                           double farthest, std::shared_ptr<const FieldPatches> patches)
    : field_(std::move(field)), grid_(std::move(grid)), patches_(std::move(patches)), farthest_(farthest) {}

const SiteModel& FieldOfSites::model(const SurfacePlace& site) const {
  const bool root = deep_ != nullptr && deep_->size() > 0;
  if (site.facet == last_.facet && site.at == last_.at && (has_root_ || !root)) return model_;
  if (patches_ && patches_->has(site.facet)) {
    patches_->fill(site, root, model_);
    has_root_ = root;
  } else {
    model_ = field_->at(site, true);
    has_root_ = true;
  }
  last_ = site;
  return model_;
}

SiteTerms FieldOfSites::terms(const SurfacePlace& site, const Vec3& x, bool stiff) const {
  const SiteModel& here = model(site);
  return deep_ != nullptr && deep_->size() > 0 ? deep_->at(here, site, x, stiff) : here.at(x);
}

double FieldOfSites::estimate(const SurfacePlace& site, const Vec3& x) const {
  if (x.norm() > farthest_) return std::numeric_limits<double>::infinity();
  const SiteModel& here = model(site);
  return deep_ != nullptr ? deep_->estimated_error(here, site, x) : here.estimate(x);
}

TouchTerms FieldOfSites::at(const SurfacePlace& site, const Vec3& x, bool stiff) const {
  const Vec3 normal = model(site).rest().normal, across_site = model(site).where().normal;
  const double r = x.norm();
  if (!(r > farthest_)) return {terms(site, x, stiff), normal, across_site};
  const Vec3 n = x / r;
  const double beyond = r - farthest_, step = 1e-4 * farthest_;
  TouchTerms at{terms(site, farthest_ * n, true), normal, across_site};
  const Vec3 outer = terms(site, (farthest_ + step) * n, false).by_site,
             inner = terms(site, (farthest_ - step) * n, false).by_site;
  const Vec3 across = at.at.stiffness * n;
  at.at.energy -= beyond * n.dot(at.at.force);
  at.at.force -= beyond * farthest_ / r * (across - n.dot(across) * n);
  at.at.by_site += beyond / (2 * step) * (outer - inner);
  return at;
}

const SurfaceMap& FieldOfSites::map() const {
  return field_->rest().map();
}

}  // namespace forefeel
