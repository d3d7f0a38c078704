// The octree of many points at once: octants are divided from the root down, the upper two levels by one thread, the
// trees below them by all.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "geometry/index/point_octree.hpp"

namespace forefeel {
namespace {

constexpr int shared_depth = 2;  // of the nodes where the trees of the threads begin

}  // namespace

// The nodes below one of them, and their buckets. Numbers count from this part's own first ones; node 0 is its root.
struct PointOctree::Part {
  struct Point {
    double x, y, z;
    std::uint32_t id;
  };
  struct Range {
    std::size_t first, last;
    Place place;
  };
  SignedVector<Node> nodes;
  SignedVector<Bucket> buckets;

  // Sorts the points by octant; returns where the octants begin and end.
  static std::array<std::size_t, 9> divide(std::vector<Point>& points, std::vector<Point>& spare,
                                           const Range& range) {
    std::array<std::size_t, 9> start{};
    const auto octant_of = [&](const Point& p) {
      return static_cast<std::size_t>(octant(range.place.centre, Vec3(p.x, p.y, p.z)));
    };
    for (std::size_t i = range.first; i < range.last; ++i) ++start[octant_of(points[i]) + 1];
    start[0] = range.first;
    for (std::size_t child = 1; child < 9; ++child) start[child] += start[child - 1];
    std::array<std::size_t, 9> next = start;
    for (std::size_t i = range.first; i < range.last; ++i) spare[next[octant_of(points[i])]++] = points[i];
    const auto begin = spare.begin(), first = begin + static_cast<std::ptrdiff_t>(range.first);
    std::copy(first, begin + static_cast<std::ptrdiff_t>(range.last),
              points.begin() + static_cast<std::ptrdiff_t>(range.first));
    return start;
  }
  static Range child_of(const Range& range, const std::array<std::size_t, 9>& start, int child,
                        std::int32_t node) {
    const auto c = static_cast<std::size_t>(child);
    return {start[c],
            start[c + 1],
            {node, range.place.depth + 1, child_centre(range.place.centre, range.place.half, child),
             0.5 * range.place.half}};
  }
  static bool is_leaf(const Range& range) {
    return range.last - range.first <= capacity || range.place.depth >= deepest || range.place.half == 0;
  }

  void fill(const std::vector<Point>& points, const Range& range) {
    std::int32_t& head = nodes[range.place.node].bucket;
    for (std::size_t i = range.first; i < range.last; ++i) {
      if (head < 0 || buckets[head].count == capacity) {
        buckets.emplace_back();
        buckets.back().next = head;
        head = buckets.count() - 1;
      }
      Bucket& bucket = buckets[head];
      const std::uint32_t k = bucket.count++;
      bucket.x[k] = points[i].x, bucket.y[k] = points[i].y, bucket.z[k] = points[i].z;
      bucket.id[k] = points[i].id;
    }
  }
  void build(std::vector<Point>& points, std::vector<Point>& spare, const Range& range) {
    if (is_leaf(range)) return fill(points, range);
    const std::array<std::size_t, 9> start = divide(points, spare, range);
    const std::int32_t children = nodes.count();
    nodes.resize(nodes.size() + 8);
    nodes[range.place.node].children = children;
    for (int child = 0; child < 8; ++child)
      build(points, spare, child_of(range, start, child, children + child));
  }
};

// Into the nodes and buckets of the tree, from the given ones on; its node 0 is `root`.
void PointOctree::take(const Part& part, std::int32_t root, std::int32_t first_node,
                       std::int32_t first_bucket) {
  const auto shifted = [&](Node node) {
    if (node.children >= 0) node.children += first_node - 1;
    if (node.bucket >= 0) node.bucket += first_bucket;
    return node;
  };
  nodes_[root] = shifted(part.nodes[0]);
  for (std::int32_t i = 1; i < part.nodes.count(); ++i) nodes_[first_node + i - 1] = shifted(part.nodes[i]);
  for (std::int32_t i = 0; i < part.buckets.count(); ++i) {
    Bucket& bucket = buckets_[first_bucket + i];
    bucket = part.buckets[i];
    if (bucket.next >= 0) bucket.next += first_bucket;
  }
}

PointOctree::PointOctree(std::span<const Vec3> at) : size_(at.size()) {
  if (at.empty()) return;
  Box box{at.front(), at.front()};
  for (const Vec3& x : at) box = {box.low.cwiseMin(x), box.high.cwiseMax(x)};
  centre_ = box.centre();
  half_ = 0.5 * (1 + 1e-9) * box.size().maxCoeff();
  std::vector<Part::Point> points(at.size()), spare(at.size());
  for (std::uint32_t i = 0; i < at.size(); ++i) points[i] = {at[i].x(), at[i].y(), at[i].z(), i};
  nodes_.emplace_back();
  std::vector<Part::Range> ranges{{0, at.size(), {0, 0, centre_, half_}}}, below;
  for (int depth = 0; depth < shared_depth; ++depth) {
    below.clear();
    for (const Part::Range& range : ranges) {
      if (Part::is_leaf(range)) {
        below.push_back(range);
        continue;
      }
      const std::array<std::size_t, 9> start = Part::divide(points, spare, range);
      const std::int32_t children = nodes_.count();
      nodes_.resize(nodes_.size() + 8);
      nodes_[range.place.node].children = children;
      for (int child = 0; child < 8; ++child)
        below.push_back(Part::child_of(range, start, child, children + child));
    }
    ranges.swap(below);
  }
  std::vector<Part> parts(ranges.size());
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    parts[r].nodes.emplace_back();
    Part::Range range = ranges[r];
    range.place.node = 0;
    parts[r].build(points, spare, range);
  }
  std::vector<std::int32_t> first_node(ranges.size()), first_bucket(ranges.size());
  std::int32_t nodes = nodes_.count(), buckets = 0;
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    first_node[r] = std::exchange(nodes, nodes + parts[r].nodes.count() - 1);
    first_bucket[r] = std::exchange(buckets, buckets + parts[r].buckets.count());
  }
  nodes_.resize(static_cast<std::size_t>(nodes));
  buckets_.resize(static_cast<std::size_t>(buckets));
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    take(parts[r], ranges[r].place.node, first_node[r], first_bucket[r]);
    parts[r] = {};
  }
}

std::uint32_t PointOctree::farthest(const Vec3& direction) const {
  Farthest best;
  if (!nodes_.empty()) farthest_below(0, centre_, half_, direction, best);
  return best.id;
}

void PointOctree::farthest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& direction,
                                 Farthest& best) const {
  const Node& n = nodes_[node];
  if (n.children >= 0) {
    const int first = octant(Vec3::Zero(), direction);
    const double reach = 0.5 * half * direction.cwiseAbs().sum() * (1 + 1e-9);
    for (const int flip : {0, 1, 2, 4, 3, 5, 6, 7}) {
      const int child = first ^ flip;
      const Node& c = nodes_[n.children + child];
      if (c.children < 0 && c.bucket < 0) continue;
      const Vec3 at = child_centre(centre, half, child);
      if (at.dot(direction) + reach >= best.along)
        farthest_below(n.children + child, at, 0.5 * half, direction, best);
    }
    return;
  }
  for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next)
    for (std::uint32_t k = 0; k < buckets_[b].count; ++k) {
      const Bucket& bucket = buckets_[b];
      const double along = Vec3(bucket.x[k], bucket.y[k], bucket.z[k]).dot(direction);
      if (along < best.along || (along == best.along && bucket.id[k] > best.id)) continue;
      best = {along, bucket.id[k]};
    }
}

PointOctree distinct_points(std::vector<Vec3>& at, double apart) {
  PointOctree all(at);
  std::vector<char> beside(at.size());  // another position is within `apart`
#pragma omp parallel for schedule(dynamic, 1024)
  for (std::size_t i = 0; i < at.size(); ++i) beside[i] = all.has_two_within(at[i], apart) ? 1 : 0;
  if (std::ranges::none_of(beside, [](char one) { return one != 0; })) return all;
  PointOctree stay;  // of those beside others
  std::size_t kept = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (beside[i]) {
      if (stay.nearest(at[i], apart).id != PointOctree::nobody) continue;
      stay.insert(static_cast<std::uint32_t>(i), at[i]);
    }
    at[kept++] = at[i];
  }
  at.resize(kept);
  return PointOctree(at);
}

}  // namespace forefeel
