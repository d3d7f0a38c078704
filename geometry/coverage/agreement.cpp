#include "geometry/coverage/agreement.hpp"

#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/voxel_grid.hpp"

namespace forefeel {

Agreement compare_indexes(const StateSpace& space, const OctreeIndex& octree) {
  Agreement result;
  const VoxelGrid grid(space.options().box, space.options().spacing / 4);
  const Regions& regions = space.regions();
  regions.settle();
  double same = 0, known = 0;
  int longest = 0;
  PathWalk walk;
  for (std::int32_t k = 0; k < grid.count[2]; ++k)
    for (std::int32_t j = 0; j < grid.count[1]; ++j)
      for (std::int32_t i = 0, run = 0; i < grid.count[0]; ++i) {
        const Vec3 q = grid.centre({i, j, k});
        const Label d = regions.label_at(q), o = octree.label(q, walk);
        const double volume = grid.cube({i, j, k}, 1).size().prod();
        result.volume[d][o] += volume;
        if (d != Label::blank || o != Label::blank) known += volume;
        if (d == o && d != Label::blank) same += volume;
        run = d == o ? 0 : run + 1;
        if (run <= longest) continue;
        longest = run;
        const Vec3 middle = grid.centre({i - (run - 1) / 2, j, k});
        result.worst = {middle, regions.label_at(middle), octree.label(middle)};
      }
  if (known > 0) result.share = same / known;
  return result;
}

}  // namespace forefeel
