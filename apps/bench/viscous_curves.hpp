#pragma once
// Three standard tests of a viscous body, by the relaxation filter of the loop (approx/switch/relaxation.hpp) and by
// the exact solution of quasi-linear viscoelasticity, both for the elastic force f(s) [N] at depth s [m]:
//   relaxation  pressed in at once and held:   F(t) = G(t) f(s)
//   creep       pushed by a constant force P:  f(s(t)) = P J(t), with z = (f, h_1 … h_n), dz/dt = M z, z(0) = P (1, g):
//               df/dt = sum h_i / tau_i,  dh_i/dt = g_i df/dt - h_i / tau_i
//   hysteresis  pressed in and out by s(t) = d (1 - cos(2 pi t / T)) / 2:
//               F(t) = G(inf) f + sum h_i,  h_i(t) = g_i int_0^t exp(-(t - u) / tau_i) f'(s) s'(u) du, by Gauss's rule
// G: relaxation function, g_i and tau_i: share and time [s] of branch i (relaxation.hpp), T: period [s]. For a linear
// law all three are exact for the body as well.

#include <cstddef>
#include <span>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

// Force against depth on the straight line x = s n, by cubic Hermite polynomials between tight solves.
class ElasticLine {
 public:
  // states: usable, at increasing depth from rest; n: unit vector.
  ElasticLine(std::span<const State> states, const Vec3& n);

  double depth() const { return depths_.back(); }
  double force(double s) const;  // [N]
  double slope(double s) const;  // [N/m]
  double place(double f) const;  // s with force(s) = f, by bisection; at most depth() [m]

 private:
  std::size_t interval(double s) const;

  std::vector<double> depths_, forces_, slopes_;
};

// x: time [s], or depth [m] of a loop; filter and exact at the same places.
struct ViscousCurve {
  std::vector<double> x, filter, exact;
  double period = 0;                                // of a loop [s]
  double largest() const;                           // difference of both, of the largest exact value [1]
  double area(const std::vector<double>& y) const;  // enclosed by a closed loop [J]
};

// In steps of `frame` [s]; only about `points` of them are returned, evenly in the logarithm of time.
ViscousCurve relaxation_curve(const ElasticLine& line, const Viscosity& viscosity, double frame,
                              std::size_t points);
// The depth that the constant force `push` [N] reaches.
ViscousCurve creep_curve(const ElasticLine& line, const Viscosity& viscosity, double push, double frame,
                         std::size_t points);
// The third period.
ViscousCurve hysteresis_loop(const ElasticLine& line, const Viscosity& viscosity, double period,
                             double frame);

}  // namespace forefeel
