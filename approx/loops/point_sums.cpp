// Compiled once per instruction set, with -ffast-math: sums whose order of addition is free.
#include "approx/loops/point_sums.hpp"

#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {

void supports(std::size_t n, const double* px, const double* py, const double* pz, const double axes[13][3],
              double low[13], double high[13]) {
  const double* __restrict x = px;
  const double* __restrict y = py;
  const double* __restrict z = pz;
  for (int k = 0; k < 13; ++k) {
    const double a = axes[k][0], b = axes[k][1], c = axes[k][2];
    double least = 1e300, most = -1e300;
    for (std::size_t i = 0; i < n; ++i) {
      const double along = a * x[i] + b * y[i] + c * z[i];
      least = along < least ? along : least;
      most = along > most ? along : most;
    }
    low[k] = least;
    high[k] = most;
  }
}

void extent(std::size_t n, const double* __restrict px, const double* __restrict py,
            const double* __restrict pz, const double* __restrict weight, double out[5]) {
  double x = 0, y = 0, z = 0, squares = 0, largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = weight[i], square = w * (px[i] * px[i] + py[i] * py[i] + pz[i] * pz[i]);
    x += w * px[i];
    y += w * py[i];
    z += w * pz[i];
    squares += square;
    largest = square > largest ? square : largest;
  }
  const double all[5] = {x, y, z, squares, largest};
  for (int k = 0; k < 5; ++k) out[k] = all[k];
}

void distances(std::size_t n, const double* __restrict px, const double* __restrict py,
               const double* __restrict pz, const double* __restrict weight, const double y[3],
               double* __restrict distance, double out[2]) {
  const double y0 = y[0], y1 = y[1], y2 = y[2];
  double least = 1e300, most = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = px[i] - y0, dy = py[i] - y1, dz = pz[i] - y2;
    const double r = __builtin_sqrt(dx * dx + dy * dy + dz * dz), counted = weight[i] * r;
    distance[i] = r;
    most = counted > most ? counted : most;
    const double near = weight[i] > 0 ? r : 1e300;
    least = near < least ? near : least;
  }
  out[0] = least;
  out[1] = most;
}

void tangent(std::size_t n, const double* __restrict px, const double* __restrict py,
             const double* __restrict pz, const double* __restrict weight, const double* __restrict data,
             std::size_t stride, const double* __restrict distance, double nearest, double farthest,
             const double base[3], double out[19]) {
  const double floor = 1e-6 * farthest + 1e-300, scale = nearest / (farthest + floor);
  Pack sum[19] = {};
  for (std::size_t i = 0; i < n; i += width) {  // arrays have room for a whole vector, of weight 0
    const Pack r = load(distance + i), apart = r > floor ? r : same(floor);
    const Pack share = (farthest / apart - 1.0) * scale;
    const Pack w = load(weight + i) * (share > 0.0 ? share * share : Pack{});
    const Pack d[3] = {load(px + i) - base[0], load(py + i) - base[1], load(pz + i) - base[2]};
    sum[0] += w;
    for (std::size_t c = 0; c < 3; ++c) {
      sum[1 + c] += w * d[c];
      sum[4 + c] += w * load(data + (3 + c) * stride + i);
      Pack along = {};
      for (std::size_t e = 0; e < 3; ++e) {
        const Pack k = w * load(data + (6 + 3 * c + e) * stride + i);
        sum[7 + 3 * c + e] += k;
        along += k * d[e];
      }
      sum[16 + c] += along;
    }
  }
  for (std::size_t k = 0; k < 19; ++k) out[k] = sum_of(sum[k]);
}

}  // namespace forefeel::FOREFEEL_ISA
