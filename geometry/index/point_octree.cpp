#include "geometry/index/point_octree.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
std::int32_t PointOctree::new_bucket() {
  if (!free_buckets_.empty()) {
    const std::int32_t bucket = free_buckets_.back();
    free_buckets_.pop_back();
    buckets_[bucket].count = 0;
    buckets_[bucket].next = -1;
    return bucket;
  }
  buckets_.emplace_back();
  return buckets_.count() - 1;
}

// Doubles the root towards `at` until it contains it. The first two distinct points set the scale.
void PointOctree::grow_to(const Vec3& at) {
  if (nodes_.empty()) {
    nodes_.emplace_back();
    centre_ = at;
    half_ = 0;
    return;
  }
  const double distance = (at - centre_).cwiseAbs().maxCoeff();
  if (half_ == 0) {
    if (distance > 0) half_ = 2 * distance;
    return;
  }
  while ((at - centre_).cwiseAbs().maxCoeff() > half_) {
    const int towards = octant(centre_, at);
    const Vec3 grown = child_centre(centre_, 2 * half_, towards);
    const std::int32_t children = nodes_.count();
    nodes_.resize(nodes_.size() + 8);
    // The old root lies on the side away from `at`: the octant opposite to the direction of growth.
    nodes_[children + (7 - towards)] = nodes_[0];
    nodes_[0] = {.children = children, .bucket = -1};
    centre_ = grown;
    half_ *= 2;
  }
}

void PointOctree::append(std::int32_t node, std::uint32_t id, const Vec3& at) {
  std::int32_t target = nodes_[node].bucket;
  if (target < 0 || buckets_[target].count == capacity) {
    const std::int32_t fresh = new_bucket();
    buckets_[fresh].next = target;
    nodes_[node].bucket = fresh;
    target = fresh;
  }
  Bucket& bucket = buckets_[target];
  const std::uint32_t k = bucket.count++;
  bucket.x[k] = at.x();
  bucket.y[k] = at.y();
  bucket.z[k] = at.z();
  bucket.id[k] = id;
}

void PointOctree::split(std::int32_t node, const Vec3& centre, double) {
  const std::int32_t children = nodes_.count();
  nodes_.resize(nodes_.size() + 8);
  std::int32_t next = nodes_[node].bucket;
  nodes_[node] = {.children = children, .bucket = -1};
  while (next >= 0) {
    const std::int32_t current = next;
    const Bucket moved = buckets_[current];
    next = moved.next;
    free_buckets_.push_back(current);
    for (std::uint32_t k = 0; k < moved.count; ++k) {
      const Vec3 at(moved.x[k], moved.y[k], moved.z[k]);
      append(children + octant(centre, at), moved.id[k], at);
    }
  }
}

void PointOctree::insert(std::uint32_t id, const Vec3& at) {
  // Points of a path come in order: the next one often falls into the last leaf.
  if (!((at - last_.centre).cwiseAbs().maxCoeff() < last_.half * (1 - 1e-9))) {
    grow_to(at);
    last_ = {0, 0, centre_, half_};
  }
  std::int32_t node = last_.node;
  Vec3 centre = last_.centre;
  double half = last_.half;
  int depth = last_.depth;
  for (;; ++depth) {
    const Node& n = nodes_[node];
    if (n.children < 0) {
      const bool full = n.bucket >= 0 && buckets_[n.bucket].count == capacity;
      if (!full || depth >= deepest || half == 0) break;
      split(node, centre, half);
    }
    const int child = octant(centre, at);
    node = nodes_[node].children + child;
    centre = child_centre(centre, half, child);
    half *= 0.5;
  }
  append(node, id, at);
  last_ = {node, depth, centre, half};
  ++size_;
}

bool PointOctree::erase(std::uint32_t id, const Vec3& at) {
  if (nodes_.empty()) return false;
  std::int32_t node = 0;
  Vec3 centre = centre_;
  double half = half_;
  while (nodes_[node].children >= 0) {
    const int child = octant(centre, at);
    node = nodes_[node].children + child;
    centre = child_centre(centre, half, child);
    half *= 0.5;
  }
  const std::int32_t head = nodes_[node].bucket;
  for (std::int32_t b = head; b >= 0; b = buckets_[b].next) {
    Bucket& bucket = buckets_[b];
    for (std::uint32_t k = 0; k < bucket.count; ++k) {
      if (bucket.id[k] != id) continue;
      // The freed place is filled from the first bucket, the only one of a chain that may be partly full.
      Bucket& first = buckets_[head];
      const auto last = static_cast<std::size_t>(--first.count);
      bucket.x[k] = first.x[last];
      bucket.y[k] = first.y[last];
      bucket.z[k] = first.z[last];
      bucket.id[k] = first.id[last];
      if (first.count == 0) {
        nodes_[node].bucket = first.next;
        free_buckets_.push_back(head);
      }
      --size_;
      return true;
    }
  }
  return false;
}

void PointOctree::nearest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& q,
                                Neighbour& best) const {
  const Node& n = nodes_[node];
  if (n.children >= 0) {
    const int first = octant(centre, q);
    // XOR by 0, 1, 2, 4, 3, 5, 6, 7 visits q's own octant, then across one, two and three planes.
    for (const int flip : {0, 1, 2, 4, 3, 5, 6, 7}) {
      const int child = first ^ flip;
      const Node& c = nodes_[n.children + child];
      if (c.children < 0 && c.bucket < 0) continue;
      const Vec3 at = child_centre(centre, half, child);
      if (squared_to_cube(at, 0.5 * half, q) <= best.squared * (1 + 1e-12))
        nearest_below(n.children + child, at, 0.5 * half, q, best);
    }
    return;
  }
  for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next) {
    const Bucket& bucket = buckets_[b];
    for (std::uint32_t k = 0; k < bucket.count; ++k) {
      const double dx = bucket.x[k] - q.x(), dy = bucket.y[k] - q.y(), dz = bucket.z[k] - q.z();
      const Neighbour found{dx * dx + dy * dy + dz * dz, bucket.id[k]};
      if (found < best) best = found;
    }
  }
}

bool PointOctree::find_in_cone(std::int32_t node, const Vec3& centre, double half, const Cone& cone,
                               double& best, Vec3& offset) const {
  const Node& n = nodes_[node];
  if (n.children < 0 && n.bucket < 0) return false;
  if (squared_to_cube(centre, half, cone.apex) > cone.squared) return false;
  // The value is Lipschitz with 1 + |cosine|; half the cube's diagonal is sqrt(3) half.
  if (cone.value(centre - cone.apex) + (1 + std::abs(cone.cosine)) * 1.7320508076 * half < best) return false;
  bool found = false;
  if (n.children >= 0) {
    const int first = octant(Vec3::Zero(), cone.axis);
    for (const int flip : {0, 1, 2, 4, 3, 5, 6, 7})
      found |= find_in_cone(n.children + (first ^ flip), child_centre(centre, half, first ^ flip), 0.5 * half,
                            cone, best, offset);
    return found;
  }
  for (std::int32_t b = n.bucket; b >= 0; b = buckets_[b].next) {
    const Bucket& bucket = buckets_[b];
    for (std::uint32_t k = 0; k < bucket.count; ++k) {
      const Vec3 d(bucket.x[k] - cone.apex.x(), bucket.y[k] - cone.apex.y(), bucket.z[k] - cone.apex.z());
      if (d.squaredNorm() > cone.squared) continue;
      if (const double value = cone.value(d); value >= best) best = value, offset = d, found = true;
    }
  }
  return found;
}

PointOctree::Neighbour PointOctree::nearest(const Vec3& q, double reach) const {
  Neighbour best{reach * reach, 0xffffffffu};
  if (nodes_.empty()) return {};
  // While the ball lies on one side of all three planes, only the child there can hold the nearest point.
  std::int32_t node = 0;
  Vec3 centre = centre_;
  double half = half_;
  while (nodes_[node].children >= 0 &&
         (q - centre).cwiseAbs().minCoeff() > reach * (1 + 1e-9) + 1e-12 * half) {
    const int child = octant(centre, q);
    node = nodes_[node].children + child;
    centre = child_centre(centre, half, child);
    half *= 0.5;
  }
  nearest_below(node, centre, half, q, best);
  if (best.id == 0xffffffffu) best.squared = std::numeric_limits<double>::infinity();
  return best;
}

void PointOctree::nearest_below(std::int32_t node, const Vec3& centre, double half, const Vec3& q,
                                std::size_t n, std::vector<Neighbour>& heap) const {
  const Node& here = nodes_[node];
  if (here.children >= 0) {
    const int first = octant(centre, q);
    for (const int flip : {0, 1, 2, 4, 3, 5, 6, 7}) {
      const int child = first ^ flip;
      const Node& c = nodes_[here.children + child];
      if (c.children < 0 && c.bucket < 0) continue;
      const Vec3 at = child_centre(centre, half, child);
      if (heap.size() < n || squared_to_cube(at, 0.5 * half, q) <= heap.front().squared * (1 + 1e-12))
        nearest_below(here.children + child, at, 0.5 * half, q, n, heap);
    }
    return;
  }
  for (std::int32_t b = here.bucket; b >= 0; b = buckets_[b].next) {
    const Bucket& bucket = buckets_[b];
    for (std::uint32_t k = 0; k < bucket.count; ++k) {
      const double dx = bucket.x[k] - q.x(), dy = bucket.y[k] - q.y(), dz = bucket.z[k] - q.z();
      const Neighbour found{dx * dx + dy * dy + dz * dz, bucket.id[k]};
      if (heap.size() < n) {
        heap.push_back(found);
        std::push_heap(heap.begin(), heap.end());
      } else if (found < heap.front()) {
        std::pop_heap(heap.begin(), heap.end());
        heap.back() = found;
        std::push_heap(heap.begin(), heap.end());
      }
    }
  }
}

void PointOctree::nearest(const Vec3& q, std::size_t n, std::vector<Neighbour>& out) const {
  out.clear();
  if (nodes_.empty() || n == 0) return;
  nearest_below(0, centre_, half_, q, n, out);
  std::sort_heap(out.begin(), out.end());
}

namespace {

void keep_ids(const std::vector<PointOctree::Neighbour>& found, std::vector<StateId>& out) {
  out.clear();
  out.reserve(found.size());
  for (const PointOctree::Neighbour& neighbour : found) out.push_back({neighbour.id});
}

}  // namespace

void PointOctree::nearest(const Vec3& q, std::size_t n, std::vector<StateId>& out) const {
  thread_local std::vector<Neighbour> found;
  nearest(q, n, found);
  keep_ids(found, out);
}

void PointOctree::within(const Vec3& q, double radius, std::vector<StateId>& out) const {
  thread_local std::vector<Neighbour> found;
  found.clear();
  for_each_within(q, radius, [&](std::uint32_t id, const Vec3&, double squared) {
    found.push_back({squared, id});
  });
  std::sort(found.begin(), found.end());
  keep_ids(found, out);
}

}  // namespace forefeel
