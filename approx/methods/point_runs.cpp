#include "approx/methods/point_runs.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>
#include <vector>

#include "geometry/index/morton_order.hpp"

namespace forefeel {
namespace {

constexpr std::size_t least_run = 128;  // points: makers of models are costly beside fewer
constexpr std::size_t most_runs = 512;
constexpr double curve_cells = 4096;  // along the longest side of the points

std::vector<std::uint32_t> along_curve(std::span<const Vec3> points) {
  Box box{points.front(), points.front()};
  for (const Vec3& x : points) box = {box.low.cwiseMin(x), box.high.cwiseMax(x)};
  const double side = box.size().maxCoeff();
  return morton_order(points, box, side > 0 ? side / curve_cells : 1);
}

}  // namespace

std::size_t count_runs(std::size_t points) {
  return std::clamp<std::size_t>((points + least_run - 1) / least_run, 1, most_runs);
}

void for_each_run(std::span<const Vec3> points, const std::function<void(PointRun, std::size_t)>& work,
                  const std::function<void(double)>& show) {
  if (points.empty()) return;
  const std::vector<std::uint32_t> order = along_curve(points);
  const std::size_t runs = count_runs(points.size());
  const auto first = [&](std::size_t run) { return run * points.size() / runs; };
  std::exception_ptr failed;
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t run = 0; run < runs; ++run) {
    try {
      work(PointRun(order).subspan(first(run), first(run + 1) - first(run)), run);
    } catch (...) {
#pragma omp critical(forefeel_point_runs)
      if (!failed) failed = std::current_exception();
    }
    std::size_t now = 0;
#pragma omp atomic capture
    now = ++done;
    if (show && omp_get_thread_num() == 0) show(static_cast<double>(now) / static_cast<double>(runs));
  }
  if (failed) std::rethrow_exception(failed);
}

}  // namespace forefeel
