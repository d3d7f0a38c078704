#include "scheduling/touch/touch_field.hpp"

namespace forefeel {

FieldOfSites::FieldOfSites(std::shared_ptr<const SiteField> field) : field_(std::move(field)) {}

TouchTerms FieldOfSites::at(const SurfacePlace& site, const Vec3& x) const {
  if (site.facet != last_.facet || site.at != last_.at) {
    model_ = field_->at(site, true);
    last_ = site;
  }
  return {model_.at(x), model_.rest().normal};
}

const SurfaceMap& FieldOfSites::map() const {
  return field_->rest().map();
}

}  // namespace forefeel
