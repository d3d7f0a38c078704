#include "geometry/agreement.hpp"

#include <cmath>

namespace forefeel {

Agreement compare_indexes(const StateSpace& space, const OctreeIndex& octree, const Box& box, double step) {
  Agreement result;
  std::array<int, 3> count{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    count[axis] = std::max(1, static_cast<int>(std::lround(box.size()[static_cast<Eigen::Index>(axis)] / step)));
  const Vec3 side = box.size().cwiseQuotient(Vec3(count[0], count[1], count[2]));
  double same = 0, known = 0;
  int longest = 0;
  for (int k = 0; k < count[2]; ++k)
    for (int j = 0; j < count[1]; ++j)
      for (int i = 0, run = 0; i < count[0]; ++i) {
        const Vec3 q = box.low + side.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
        const Label d = space.label(q), o = octree.label(q);
        const double volume = side.prod();
        result.volume[static_cast<std::size_t>(d)][static_cast<std::size_t>(o)] += volume;
        if (d != Label::blank || o != Label::blank) known += volume;
        if (d == o && d != Label::blank) same += volume;
        run = d == o ? 0 : run + 1;
        if (run > longest) {
          longest = run;
          result.worst = q - 0.5 * (run - 1) * side.cwiseProduct(Vec3::UnitX());
          result.worst_delaunay = d;
          result.worst_octree = o;
        }
      }
  if (known > 0) result.share = same / known;
  return result;
}

}  // namespace forefeel
