#include "geometry/coverage/place_walk.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {
namespace {

constexpr double ball_reach = 1.6;      // in distances of the n-th nearest state of its centre
constexpr double ball_together = 0.5;   // of that distance: places nearer to each other share a ball
constexpr std::size_t ball_states = 8;  // for each that is asked for, at most: of uneven states

}  // namespace

// False if a nearest state may lie outside the ball.
bool PlaceWalk::choose(const Vec3& q, std::size_t n, std::vector<StateId>& out) {
  const double reach = radius_ - (q - centre_).norm();
  if (!(reach > 0) || points_.size() < n || n == 0) return false;
  found_.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    const double dx = point.at.x() - q.x(), dy = point.at.y() - q.y(), dz = point.at.z() - q.z();
    found_[i] = {dx * dx + dy * dy + dz * dz, point.id};
  }
  const auto last = found_.begin() + static_cast<std::ptrdiff_t>(n) - 1;
  std::nth_element(found_.begin(), last, found_.end());
  if (!(last->squared < reach * reach * (1 - 1e-9))) return false;
  std::sort(found_.begin(), last);
  out.clear();
  for (std::size_t i = 0; i < n; ++i) out.push_back({found_[i].id});
  return true;
}

void PlaceWalk::nearest(const StateSpace& space, const Vec3& q, std::size_t n, std::vector<StateId>& out) {
  if (size_ == space.size() && choose(q, n, out)) return;
  space.points().nearest(q, n, found_);
  out.clear();
  for (const PointOctree::Neighbour& one : found_) out.push_back({one.id});
  const double far = found_.empty() ? 0 : std::sqrt(found_.back().squared);
  const bool beside = (q - last_).norm() < ball_together * far;
  last_ = q;
  radius_ = -1;
  points_.clear();
  if (!beside) return;
  space.points().for_each_within(q, ball_reach * far, [&](std::uint32_t id, const Vec3&, double) {
    points_.push_back({space[StateId{id}].at, id});
  });
  if (points_.size() > ball_states * n) return;
  centre_ = q, radius_ = ball_reach * far, size_ = space.size();
}

}  // namespace forefeel
