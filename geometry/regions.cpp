#include "geometry/regions.hpp"

#include "geometry/coverage_query.hpp"
#include "geometry/state_space.hpp"

namespace forefeel {

struct Regions::Impl {
  CoverageQuery query;
  Thresholds limits;
};

Regions::Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : impl_(new Impl{CoverageQuery(points, delaunay),
                     Thresholds(options.coverage, options.spacing, options.merge_distance * options.spacing)}) {}
Regions::~Regions() = default;

Label Regions::label_at(const Vec3& q) const {
  return impl_->query.label(q, {impl_->query.points().nearest(q).id}, impl_->limits);
}

void Regions::inserted(const Vec3&, std::span<const std::uint32_t>) {}

}  // namespace forefeel
