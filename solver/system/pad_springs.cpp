#include "solver/system/pad_springs.hpp"

namespace forefeel {

double PadSprings::energy(const double* u) const {
  double twice = 0;
  for (const Pair& p : pairs) {
    const double *a = u + 3 * p.a, *b = u + 3 * p.b;
    const double product = p.stiffness * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    twice += p.a == p.b ? product : 2 * product;
  }
  return 0.5 * twice;
}

void PadSprings::apply(const double* u, double* y) const {
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < 3; ++i) {
      *(y + 3 * p.a + i) += p.stiffness * *(u + 3 * p.b + i);
      if (p.a != p.b) *(y + 3 * p.b + i) += p.stiffness * *(u + 3 * p.a + i);
    }
}

void PadSprings::apply_lanes(const double* u, double* y) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < row; ++i) {
      *(y + row * p.a + i) += p.stiffness * *(u + row * p.b + i);
      if (p.a != p.b) *(y + row * p.b + i) += p.stiffness * *(u + row * p.a + i);
    }
}

void PadSprings::energy_lanes(const double* u, double* energy) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs) {
    const double scale = p.a == p.b ? 0.5 * p.stiffness : p.stiffness;
    for (std::int32_t i = 0; i < row; ++i)
      *(energy + i % lane_count) += scale * *(u + row * p.a + i) * *(u + row * p.b + i);
  }
}

void PadSprings::add_to(double* blocks) const {
  for (const Pair& p : pairs)
    for (std::int64_t i = 0; i < 3; ++i) *(blocks + 9 * p.block + 4 * i) += p.stiffness;
}

}  // namespace forefeel
