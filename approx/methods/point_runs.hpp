#pragma once
// Work at many points by all threads. Points are taken along a Z-curve, in runs of points that lie together: a model of
// one neighbour set serves those that share it. Runs do not depend on the number of threads.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "geometry/common/types.hpp"

namespace forefeel {

// Numbers of points, in the order of the curve.
using PointRun = std::span<const std::uint32_t>;

// Calls work(run, number of the run) once for each run, from all threads; runs are numbered from 0 to below
// count_runs(#points). show: called by the calling thread with the share done. The first exception is thrown again.
void for_each_run(std::span<const Vec3> points, const std::function<void(PointRun, std::size_t)>& work,
                  const std::function<void(double)>& show = {});
std::size_t count_runs(std::size_t points);

}  // namespace forefeel
