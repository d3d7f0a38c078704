#include "geometry/coverage/regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/coverage/bridge.hpp"
#include "geometry/coverage/fill_distance.hpp"
#include "geometry/coverage/region_tree.hpp"
#include "geometry/coverage/voxel_summary.hpp"

namespace forefeel {
struct Regions::Impl {
  RegionTree tree;
  double sparse_distance;  // kappa_p
};

Regions::Regions(const PointOctree& points, DelaunayIndex& delaunay, const StateSpaceOptions& options)
    : impl_(new Impl{RegionTree(points, delaunay, options), options.coverage.sparse_distance}) {}
Regions::~Regions() = default;

Label Regions::label_at(const Vec3& q) const {
  return impl_->tree.label_at(q);
}
void Regions::inserted(const Vec3& at, std::span<const std::uint32_t> disturbed) {
  impl_->tree.inserted(at, disturbed);
}
void Regions::settle(const std::function<void(double)>& progress) const {
  impl_->tree.settle(progress);
}

RegionSummary Regions::summary() const {
  settle();
  const RegionTree& tree = impl_->tree;
  VoxelLabels voxels(tree.grid().box, tree.grid().side, 0);
  tree.for_each_leaf([&](const RegionNode& leaf) {
    voxels.fill(leaf.low, leaf.width(), static_cast<std::uint8_t>(leaf.label));
  });
  RegionSummary result = summarise(
      voxels, [&](const Vec3& q) { return rim_reach(impl_->sparse_distance, tree.spacing_at(q)); }, true);
  find_sides(result.components, impl_->sparse_distance,
             [&tree](const Vec3& place, std::vector<Vec3>& offsets) {
               tree.query().points().offsets_within(place, tree.gap_radius(place), offsets);
             });
  return result;
}

// delta has its maxima at Voronoi vertices (circumcentres of the cells) inside the box, or on its boundary.
double Regions::fill_distance() const {
  const RegionTree& tree = impl_->tree;
  const PointOctree& points = tree.query().points();
  if (points.size() == 0) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (const EmptyBall& ball : empty_balls(tree.query().delaunay(), tree.grid().box))
    largest = std::max(largest, ball.radius);
  return largest_in_box([&](const Vec3& q) { return std::sqrt(points.nearest(q).squared); }, tree.grid().box,
                        largest, 4e-3 * tree.grid().side);
}

std::optional<EmptyBall> Regions::largest_hole() const {
  const RegionTree& tree = impl_->tree;
  std::vector<EmptyBall> balls = empty_balls(tree.query().delaunay(), tree.grid().box);
  std::ranges::make_heap(balls, smaller);
  while (!balls.empty()) {
    std::ranges::pop_heap(balls, smaller);
    const EmptyBall ball = balls.back();
    balls.pop_back();
    if (tree.query().delaunay().spread(ball.centre, {}).inside) return ball;
  }
  return std::nullopt;
}

}  // namespace forefeel
