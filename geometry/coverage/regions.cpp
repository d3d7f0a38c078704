#include "geometry/coverage/regions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <span>

#include "geometry/coverage/block_labels.hpp"
#include "geometry/index/adaptive_lattice.hpp"
#include "geometry/index/morton_order.hpp"

namespace forefeel {
namespace {

// Along a Z-curve, without those within `apart` of an earlier one that stays.
CoveredStates index_states(std::span<const Vec3> states, const Box& box, double spacing, double apart) {
  CoveredStates kept;
  kept.at.reserve(states.size());
  for (const std::uint32_t i : morton_order(states, box, spacing)) {
    kept.at.push_back(states[i]);
    kept.largest = std::max(kept.largest, states[i].cwiseAbs().maxCoeff());
  }
  kept.points = distinct_points(kept.at, apart);
  return kept;
}

// Proves the label gap or blank for all places within a given distance of a place, if all of them are farther than
// kappa_p h from every state.
class FarProof {
 public:
  explicit FarProof(const PointOctree& points) : points_(points) {}

  // Gap or blank for all places within e of q; nothing if neither is proven. nearest: offset of the state nearest to q.
  std::optional<Label> label(const Thresholds& limits, const Vec3& q, double e, const Vec3& nearest) {
    Vec3 axis = -nearest.normalized();
    if (find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) return Label::blank;
    // A move by e turns a direction by at most asin(e / nearest), so a correspondingly smaller angle at q proves the
    // label for all voxels.
    directions_.clear();
    points_.for_each_within(q, limits.gap_radius - e, [&](std::uint32_t, const Vec3& offset, double squared) {
      directions_.push(offset / std::sqrt(squared));
    });
    const double turn = std::asin(std::min(1.0, e / nearest.norm())) + 1e-9;
    const double angle = std::acos(std::clamp(limits.gap_cos, -1.0, 1.0));
    if (angle > turn && solver_.at_most(directions_, std::cos(angle - turn), &axis)) return Label::gap;
    if (!axis.allFinite() || !find_axis(q, limits.gap_radius, limits.gap_cos, e, axis)) return std::nullopt;
    return Label::blank;
  }

 private:
  // Turns `axis` until, seen from every point within e of q, the angle between it and each state within the radius
  // exceeds arccos(cosine). False if six turns do not suffice. The margin (1 + |c|) e covers the points within e:
  //   a . (d - s) <= a . d + e   and   c |d - s| >= c |d| - |c| e   for |s| <= e.
  bool find_axis(const Vec3& q, double radius, double cosine, double e, Vec3& axis) const {
    const double margin = (1 + std::abs(cosine)) * e;
    constexpr double slack = 2e-9, spare = 0.01;
    for (int turn = 0; turn < 6; ++turn) {
      Vec3 d;
      if (!points_.find_in_cone(q, axis, cosine - slack, margin, radius + e, d)) return true;
      const double length = d.norm();
      if (!(length > 0)) return false;
      const Vec3 u = d / length;
      const double wanted = cosine - margin / length - spare;
      const Vec3 aside = axis - axis.dot(u) * u;
      const double width = aside.norm();
      if (wanted <= -1 || width < 1e-6) return false;
      axis = wanted * u + std::sqrt(1 - wanted * wanted) / width * aside;
      axis.normalize();
    }
    return false;
  }

  const PointOctree& points_;
  Directions directions_;
  ConeSolver solver_;
};

class FarLabels {
 public:
  FarLabels(const CoveredStates& states, const VoxelLimits& limits, VoxelLabels& voxels)
      : states_(states),
        limits_(limits),
        voxels_(voxels),
        query_(states.points, none_),
        proof_(states.points) {}

  void resolve(const Voxel& low, std::int32_t width) {
    Voxel end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      end[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(low[axis] + width, voxels_.count[axis]));
    if (!any_unset(low, end)) return;
    const Thresholds* limits = limits_.over(voxels_, low, end);
    if (const auto label = limits ? label_of(low, width, *limits) : std::nullopt)
      return fill(low, end, *label);
    const std::int32_t half = width / 2;
    for (int child = 0; child < 8; ++child) {
      const Voxel part{low[0] + (child & 1 ? half : 0), low[1] + (child & 2 ? half : 0),
                       low[2] + (child & 4 ? half : 0)};
      if (part[0] < end[0] && part[1] < end[1] && part[2] < end[2]) resolve(part, half);
    }
  }

 private:
  template <class Visit>
  void for_each_row(const Voxel& low, const Voxel& end, Visit&& visit) const {
    for (std::int64_t k = low[2]; k < end[2]; ++k)
      for (std::int64_t j = low[1]; j < end[1]; ++j) {
        std::uint8_t* const row = voxels_.label.data() + voxels_.index(low[0], j, k);
        if (visit(row, row + (end[0] - low[0]))) return;
      }
  }
  bool any_unset(const Voxel& low, const Voxel& end) const {
    bool any = false;
    for_each_row(low, end, [&](const std::uint8_t* first, const std::uint8_t* last) {
      return any = std::find(first, last, unset_label) != last;
    });
    return any;
  }
  void fill(const Voxel& low, const Voxel& end, Label label) {
    for_each_row(low, end, [&](std::uint8_t* first, std::uint8_t* last) {
      std::replace(first, last, unset_label, static_cast<std::uint8_t>(label));
      return false;
    });
  }
  // Of all voxels of the cube that are unset; nothing if they may differ.
  std::optional<Label> label_of(const Voxel& low, std::int32_t width, const Thresholds& limits) {
    const VoxelGrid& grid = voxels_.grid;
    const Vec3 q = grid.middle(low, width);
    if (width == 1) return label_at(q, limits);
    const double e = grid.reach(low, width) * (1 + 1e-9), tiny = 1e-9 * grid.side;
    const PointOctree::Neighbour nearest = states_.points.nearest(q);
    if (nearest.id == PointOctree::nobody) return Label::blank;
    const double distance = std::sqrt(nearest.squared);
    if (distance > limits.sparse_distance + e + tiny)
      return proof_.label(limits, q, e, states_.at[nearest.id] - q);
    return distance + e + tiny <= limits.sparse_distance ? std::optional(Label::sparse) : std::nullopt;
  }
  Label label_at(const Vec3& q, const Thresholds& limits) const {
    if (states_.points.nearest(q, limits.sparse_distance).id != PointOctree::nobody) return Label::sparse;
    return query_.enclosed(q, limits.gap_radius, limits.gap_cos, limits.merge) ? Label::gap : Label::blank;
  }

  const CoveredStates& states_;
  const VoxelLimits& limits_;
  VoxelLabels& voxels_;
  DelaunayIndex none_;
  CoverageQuery query_;
  FarProof proof_;
};

// Labels every voxel that is still unset_label. Cubes of voxels that are all far from every state are labelled together
// if a bound proves one label for all of them.
void label_far(const CoveredStates& states, const VoxelLimits& limits, VoxelLabels& voxels) {
  const RootCubes roots(voxels.grid);
#pragma omp parallel
  {
    FarLabels labels(states, limits, voxels);
#pragma omp for schedule(dynamic, 8)
    for (std::int32_t root = 0; root < roots.size(); ++root)
      labels.resolve(roots.low(root), 1 << roots.level);
  }
}

// ---- holes

// The balls of the Delaunay cells that are not flat, with their centres in the box: delta has its maxima there, or on
// the faces of the box.
std::vector<EmptyBall> empty_balls(const DelaunayIndex& delaunay, const Box& box) {
  std::vector<EmptyBall> balls;
  for (const DelaunayIndex::Cell& cell : delaunay.cells())
    if (std::isfinite(cell.circumradius) && box.contains(cell.centre))
      balls.push_back({cell.circumradius, cell.centre});
  return balls;
}

// The largest delta at the corners and on the faces of a box, and `known`, if that is larger [m].
double largest_in_box(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                      double tolerance) {
  double largest = known;
  for (int corner = 0; corner < 8; ++corner)
    largest =
        std::max(largest, delta({(corner & 1 ? box.high : box.low).x(), (corner & 2 ? box.high : box.low).y(),
                                 (corner & 4 ? box.high : box.low).z()}));
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      Box face = box;
      (upper ? face.low : face.high)[axis] = (upper ? face.high : face.low)[axis];
      largest = largest_distance(delta, face, largest, tolerance);
    }
  return largest;
}

}  // namespace

double largest_distance(const std::function<double(const Vec3&)>& delta, const Box& box, double known,
                        double tolerance) {
  struct Part {
    double bound;
    Box box;
    bool operator<(const Part& other) const { return bound < other.bound; }
  };
  std::priority_queue<Part> queue;
  const auto push = [&](const Box& part) {
    const double here = delta(part.centre());
    known = std::max(known, here);
    const double bound = here + 0.5 * part.size().norm();
    if (bound > known + tolerance) queue.push({bound, part});
  };
  push(box);
  while (!queue.empty() && queue.top().bound > known + tolerance) {
    const Part part = queue.top();
    queue.pop();
    int longest = 0;
    part.box.size().maxCoeff(&longest);
    Box low = part.box, high = part.box;
    low.high[longest] = high.low[longest] = part.box.centre()[longest];
    push(low);
    push(high);
  }
  return known;
}

std::vector<EmptyBall> empty_balls(const DelaunayIndex& delaunay, const Box& box, double least) {
  constexpr std::size_t most = 1000;
  std::vector<EmptyBall> found, balls = empty_balls(delaunay, box);
  std::erase_if(balls, [&](const EmptyBall& ball) { return !(ball.radius > least); });
  std::ranges::stable_sort(balls, std::greater(), &EmptyBall::radius);
  for (const EmptyBall& ball : balls) {
    if (found.size() == most) break;
    const auto holds = [&](const EmptyBall& larger) {
      return (larger.centre - ball.centre).norm() < larger.radius;
    };
    if (std::ranges::none_of(found, holds) && delaunay.spread(ball.centre, {}).inside) found.push_back(ball);
  }
  return found;
}

struct Regions::Impl {
  StateSpaceOptions options;
  CoveredStates states;
  VoxelLabels voxels;
  double fill = 0;
  std::vector<EmptyBall> balls;  // from large to small; the last is in the hull of the states
  DelaunayIndex
      large;  // of the states at the hull or beside large cells: all cells that no block was sure of

  Impl(std::span<const Vec3> at, const StateSpaceOptions& given)
      : options(given),
        states(index_states(at, given.box, given.spacing, given.merge_distance * given.spacing)),
        voxels(given.box, given.spacing / 4, unset_label) {}

  void add_large_cells(BlockFindings found);
  double spacing_at(const Vec3& q) const {
    return options.lattice ? options.lattice->spacing_at(q) : options.spacing;
  }
};

// The cells that no block was certain of have only open states as corners.
void Regions::Impl::add_large_cells(BlockFindings found) {
  std::ranges::sort(found.open);
  StateId last;
  for (const std::uint32_t i : found.open) last = large.insert({i}, states.at[i], last);
  for (const EmptyBall& ball : empty_balls(large, options.box)) found.balls.push_back(ball);
  std::ranges::stable_sort(found.balls, std::greater(), &EmptyBall::radius);
  fill = found.fill;
  StateId near;
  for (const EmptyBall& ball : found.balls) {
    if (states.points.nearest(ball.centre, ball.radius * (1 - 1e-9)).id != PointOctree::nobody) continue;
    fill = std::max(fill, ball.radius);
    balls.push_back(ball);
    const Spread spread = large.spread(ball.centre, near);
    near = spread.states[0];
    if (spread.inside) break;
  }
}

Regions::Regions(std::vector<Vec3> states, const StateSpaceOptions& options,
                 const std::function<void(double)>& progress) {
  check_options(options);
  impl_ = std::make_unique<Impl>(states, options);
  std::vector<Vec3>().swap(states);
  Impl& my = *impl_;
  const auto show = [&](double share) {
    if (progress) progress(share);
  };
  const VoxelLimits limits(options, my.voxels);
  my.add_large_cells(label_blocks(my.states, limits, my.voxels, [&](double share) { show(0.9 * share); }));
  show(0.95);
  label_far(my.states, limits, my.voxels);
  show(1);
}
Regions::~Regions() = default;
Regions::Regions(Regions&&) noexcept = default;
Regions& Regions::operator=(Regions&&) noexcept = default;

const StateSpaceOptions& Regions::options() const {
  return impl_->options;
}

Label Regions::label_at(const Vec3& q) const {
  const Voxel v = impl_->voxels.grid.voxel_of(q);
  return static_cast<Label>(impl_->voxels.label[impl_->voxels.index(v[0], v[1], v[2])]);
}

RegionSummary Regions::summary(bool with_leaves) const {
  const Impl& my = *impl_;
  const CoverageOptions& coverage = my.options.coverage;
  RegionSummary result = summarise(
      my.voxels, [&](const Vec3& q) { return rim_reach(coverage.sparse_distance, my.spacing_at(q)); },
      with_leaves);
  const Thresholds usual(coverage, my.options.spacing, 0);
  find_sides(result.components, coverage.sparse_distance, [&](const Vec3& place, std::vector<Vec3>& offsets) {
    const double radius = usual.gap_radius * (my.spacing_at(place) / my.options.spacing);
    my.states.points.offsets_within(place, radius, offsets);
  });
  return result;
}

// delta has its maxima at Voronoi vertices (circumcentres of the cells) inside the box, or on its boundary.
double Regions::fill_distance() const {
  const PointOctree& points = impl_->states.points;
  if (points.size() == 0) return std::numeric_limits<double>::infinity();
  return largest_in_box([&](const Vec3& q) { return std::sqrt(points.nearest(q).squared); },
                        impl_->options.box, impl_->fill, 4e-3 * impl_->voxels.grid.side);
}

std::optional<EmptyBall> Regions::largest_hole() const {
  const Impl& my = *impl_;
  if (my.balls.empty() || !my.large.spread(my.balls.back().centre, {}).inside) return std::nullopt;
  return my.balls.back();
}

}  // namespace forefeel
