#pragma once
// Nearest and range queries over points, exact, under insertion and removal: an octree with buckets of 16
// points. The root doubles when a point falls outside; points at one place are chained at the deepest level.
// O(log n) insertion, O(log n + k) queries of k results. Const members may run in many threads at once.
// Lengths in [m].

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "geometry/common/types.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

class PointOctree {
 public:
  static constexpr std::uint32_t nobody = 0xffffffffu;  // id where there is no point
  struct Neighbour {
    double squared = std::numeric_limits<double>::infinity();  // squared distance [m^2]
    std::uint32_t id = nobody;
    friend bool operator<(const Neighbour& a, const Neighbour& b) {
      return a.squared < b.squared || (a.squared == b.squared && a.id < b.id);
    }
  };

  PointOctree() = default;
  // Of points with their indices as ids: as if inserted one by one, by all threads. O(n log n).
  explicit PointOctree(std::span<const Vec3> at);

  std::size_t size() const { return size_; }
  void insert(std::uint32_t id, const Vec3& at);
  bool erase(std::uint32_t id, const Vec3& at);  // false: not there

  // The nearest point within `reach` [m]; id `nobody` if there is none. The lowest id wins a tie.
  Neighbour nearest(const Vec3& q, double reach = std::numeric_limits<double>::infinity()) const;
  // The n nearest, or those within a radius [m]: by distance, ties by id.
  void nearest(const Vec3& q, std::size_t n, std::vector<Neighbour>& out) const;
  void nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const;
  void within(const Vec3& q, double radius, std::vector<StateId>& out) const;

  bool has_two_within(const Vec3& q, double radius) const {
    int found = 0;
    return find_within(q, radius, [&](std::uint32_t) { return ++found > 1; }) != nobody;
  }
  // The point farthest along a direction, the lowest id of several; nobody without points.
  std::uint32_t farthest(const Vec3& direction) const;

  // visit(id, offset from q, squared distance) for every point with |x - q| <= radius, in no particular
  // order.
  template <class Visit>
  void for_each_within(const Vec3& q, double radius, Visit&& visit) const {
    if (nodes_.empty()) return;
    visit_within(0, centre_, half_, q, radius * radius, visit);
  }

  // The first point within the radius that accept(id) takes, in the order of the tree; nobody if there is none.
  template <class Accept>
  std::uint32_t find_within(const Vec3& q, double radius, Accept&& accept) const {
    return nodes_.empty() ? nobody : find_below(0, centre_, half_, q, radius * radius, accept);
  }

  // Appends the offsets from q of the points within the radius.
  void offsets_within(const Vec3& q, double radius, std::vector<Vec3>& out) const {
    for_each_within(q, radius, [&](std::uint32_t, const Vec3& offset, double) { out.push_back(offset); });
  }

  // Finds the point x within `reach` of q with the largest value of axis . d - cosine |d| + margin, d = x - q.
  // True if that value is positive; offset is then d. False: the cone about the unit axis is empty, even if it
  // is widened by the margin [m].
  bool find_in_cone(const Vec3& q, const Vec3& axis, double cosine, double margin, double reach,
                    Vec3& offset) const {
    if (nodes_.empty()) return false;
    double best = 0;
    return find_in_cone(0, centre_, half_, {q, axis, cosine, margin, reach * reach}, best, offset);
  }

  // Calls visit(offset) for the points within the radius. A leaf that is small compared with its distance is
  // visited once, with the mean of its points; otherwise each point is visited. Ends when visit() returns false.
  template <class Visit>
  void for_each_leaf_within(const Vec3& q, double radius, Visit&& visit) const {
    if (!nodes_.empty()) visit_leaves(0, centre_, half_, q, radius * radius, visit);
  }

 private:
  static constexpr std::uint32_t capacity = 16;
  static constexpr int deepest = 48;
  struct Bucket {
    std::array<double, capacity> x, y, z;
    std::array<std::uint32_t, capacity> id;
    std::uint32_t count = 0;
    std::int32_t next = -1;
  };
  struct Node {
    std::int32_t children = -1;  // first of eight
    std::int32_t bucket = -1;
  };

  static int octant(const Vec3& centre, const Vec3& q) {
    return (q.x() >= centre.x() ? 1 : 0) | (q.y() >= centre.y() ? 2 : 0) | (q.z() >= centre.z() ? 4 : 0);
  }
  static Vec3 child_centre(const Vec3& centre, double half, int child) {
    const double step = 0.5 * half;
    return {centre.x() + ((child & 1) ? step : -step), centre.y() + ((child & 2) ? step : -step),
            centre.z() + ((child & 4) ? step : -step)};
  }
  static double squared_to_cube(const Vec3& centre, double half, const Vec3& q) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double beyond = std::abs(q[axis] - centre[axis]) - half;
      if (beyond > 0) sum += beyond * beyond;
    }
    return sum;
  }

  template <class Visit>
  void visit_within(std::int32_t node, const Vec3& centre, double half, const Vec3& q, double squared,
                    Visit& visit) const {
    // A cube is skipped only when it is farther by more than rounding.
    if (squared_to_cube(centre, half, q) > squared * (1 + 1e-12)) return;
    const Node& n = nodes_[node];
    if (n.children >= 0) {
      for (int child = 0; child < 8; ++child)
        visit_within(n.children + child, child_centre(centre, half, child), 0.5 * half, q, squared, visit);
      return;
    }
    for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next) {
      const Bucket& bucket = buckets_[b];
      for (std::uint32_t k = 0; k < bucket.count; ++k) {
        const Vec3 offset(bucket.x[k] - q.x(), bucket.y[k] - q.y(), bucket.z[k] - q.z());
        const double d = offset.squaredNorm();
        if (d <= squared) visit(bucket.id[k], offset, d);
      }
    }
  }

  template <class Accept>
  std::uint32_t find_below(std::int32_t node, const Vec3& centre, double half, const Vec3& q, double squared,
                           Accept& accept) const {
    if (squared_to_cube(centre, half, q) > squared * (1 + 1e-12)) return nobody;
    const Node& n = nodes_[node];
    for (int child = 0; n.children >= 0 && child < 8; ++child) {
      const std::uint32_t found =
          find_below(n.children + child, child_centre(centre, half, child), 0.5 * half, q, squared, accept);
      if (found != nobody) return found;
    }
    for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next) {
      const Bucket& bucket = buckets_[b];
      for (std::uint32_t k = 0; k < bucket.count; ++k)
        if ((Vec3(bucket.x[k], bucket.y[k], bucket.z[k]) - q).squaredNorm() <= squared &&
            accept(bucket.id[k]))
          return bucket.id[k];
    }
    return nobody;
  }

  template <class Visit>
  bool visit_leaves(std::int32_t node, const Vec3& centre, double half, const Vec3& q, double squared,
                    Visit& visit) const {
    if (squared_to_cube(centre, half, q) > squared) return true;
    const Node& n = nodes_[node];
    if (n.children >= 0) {
      for (int child = 0; child < 8; ++child)
        if (!visit_leaves(n.children + child, child_centre(centre, half, child), 0.5 * half, q, squared,
                          visit))
          return false;
      return true;
    }
    const bool small = 16 * half * half <= (centre - q).squaredNorm();
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next) {
      const Bucket& bucket = buckets_[b];
      for (std::uint32_t k = 0; k < bucket.count; ++k) {
        const Vec3 offset(bucket.x[k] - q.x(), bucket.y[k] - q.y(), bucket.z[k] - q.z());
        if (offset.squaredNorm() > squared) continue;
        if (small) {
          sum += offset, ++count;
        } else if (!visit(offset)) {
          return false;
        }
      }
    }
    return count == 0 || visit(Vec3(sum / count));
  }

  struct Cone {
    Vec3 apex, axis;
    double cosine, margin, squared;
    double value(const Vec3& d) const { return axis.dot(d) - cosine * d.norm() + margin; }
  };
  bool find_in_cone(std::int32_t node, const Vec3& centre, double half, const Cone& cone, double& best,
                    Vec3& offset) const;
  void nearest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& q,
                     Neighbour& best) const;
  void nearest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& q, std::size_t n,
                     std::vector<Neighbour>& heap) const;
  void grow_to(const Vec3& at);
  void split(std::int32_t node, const Vec3& centre, double half);
  void append(std::int32_t node, std::uint32_t id, const Vec3& at);
  std::int32_t new_bucket();

  struct Part;
  void take(const Part& part, std::int32_t root, std::int32_t first_node, std::int32_t first_bucket);
  struct Farthest {
    double along = -std::numeric_limits<double>::infinity();
    std::uint32_t id = nobody;
  };
  void farthest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& direction,
                      Farthest& best) const;

  struct Place {
    std::int32_t node = 0;
    int depth = 0;
    Vec3 centre = Vec3::Zero();
    double half = 0;
  };

  Place last_;  // the leaf of the last insert()
  SignedVector<Node> nodes_;
  SignedVector<Bucket> buckets_;
  std::vector<std::int32_t> free_buckets_;
  Vec3 centre_ = Vec3::Zero();
  double half_ = 0;
  std::size_t size_ = 0;
};

// Takes out the positions within `apart` [m] of an earlier one that stays, by all threads; the tree of the others.
PointOctree distinct_points(std::vector<Vec3>& at, double apart);

}  // namespace forefeel
