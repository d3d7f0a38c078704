#include "scheduling/touch/touch_field.hpp"

#include <cmath>

namespace forefeel {

double farthest_of(double depth) {
  return 1.5 * std::hypot(depth, 0.5 * depth);
}

FieldOfSites::FieldOfSites(std::shared_ptr<const SiteField> field, std::shared_ptr<const SurfaceGrid> grid,
                           double farthest)
    : field_(std::move(field)), grid_(std::move(grid)), farthest_(farthest) {}

const SiteModel& FieldOfSites::model(const SurfacePlace& site) const {
  if (site.facet != last_.facet || site.at != last_.at) {
    model_ = field_->at(site, true);
    last_ = site;
  }
  return model_;
}

// By the last degrees of the jets, as of a single one (geometry/states/energy_jet.hpp).
double FieldOfSites::estimate(const SurfacePlace& site, const Vec3& x) const {
  const SiteModel& here = model(site);
  const Vec3 at = x.norm() > farthest_ ? Vec3(farthest_ / x.norm() * x) : x;
  const Vec3 fourth = here.at(at, 5).force, third = here.at(at, 4).force, second = here.at(at, 3).force;
  return std::sqrt((fourth - third).squaredNorm() + 0.25 * (third - second).squaredNorm() + 1e-12);
}

TouchTerms FieldOfSites::at(const SurfacePlace& site, const Vec3& x) const {
  model(site);
  const double r = x.norm();
  if (!(r > farthest_)) return {model_.at(x), model_.rest().normal};
  const Vec3 n = x / r;
  const double beyond = r - farthest_, step = 1e-4 * farthest_;
  TouchTerms terms{model_.at(farthest_ * n), model_.rest().normal};
  const Vec3 outer = model_.at((farthest_ + step) * n).by_site,
             inner = model_.at((farthest_ - step) * n).by_site;
  const Vec3 stiff = terms.at.stiffness * n;
  terms.at.energy -= beyond * n.dot(terms.at.force);
  terms.at.force -= beyond * farthest_ / r * (stiff - n.dot(stiff) * n);
  terms.at.by_site += beyond / (2 * step) * (outer - inner);
  return terms;
}

const SurfaceMap& FieldOfSites::map() const {
  return field_->rest().map();
}

}  // namespace forefeel
