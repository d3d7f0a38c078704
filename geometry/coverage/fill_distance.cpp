#include "geometry/coverage/fill_distance.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace forefeel {

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

std::vector<EmptyBall> empty_balls(const DelaunayIndex& delaunay, const Box& box) {
  std::vector<EmptyBall> balls;
  for (const DelaunayIndex::Cell& cell : delaunay.cells())
    if (std::isfinite(cell.circumradius) && box.contains(cell.centre))
      balls.push_back({cell.circumradius, cell.centre});
  return balls;
}

}  // namespace forefeel
