#include "approx/error/loop_energy.hpp"

#include <cmath>

namespace forefeel {

LoopEnergy loop_energy(const std::vector<Vec3>& loop, const std::function<Vec3(const Vec3&)>& force) {
  LoopEnergy energy;
  if (loop.size() < 2) return energy;
  Vec3 before = force(loop.front());
  for (std::size_t k = 1; k <= loop.size(); ++k) {
    const Vec3 &from = loop[k - 1], &to = loop[k % loop.size()];
    const Vec3 now = force(to);
    const double work = 0.5 * (before + now).dot(to - from);
    energy.net += work;
    energy.gross += std::abs(work);
    before = now;
  }
  energy.net = std::abs(energy.net);
  return energy;
}

std::vector<Vec3> ellipse(const Vec3& centre, const Vec3& a, const Vec3& b, std::size_t points) {
  std::vector<Vec3> loop;
  for (std::size_t k = 0; k < points; ++k) {
    const double u = 2 * M_PI * static_cast<double>(k) / static_cast<double>(points);
    loop.emplace_back(centre + std::cos(u) * a + std::sin(u) * b);
  }
  return loop;
}

}  // namespace forefeel
