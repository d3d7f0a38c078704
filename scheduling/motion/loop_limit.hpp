#pragma once
// The largest stiffness K [N/m] at which a loop of virtual spring, device and hand is stable, from published results.
//   m x'' + b x' + k x = F + F_h,   F = -K x - B x', sampled and held for a frame T [s]
// m [kg], b [N s/m], k [N/m]: mass, damping and stiffness of device and hand together; F_h [N]: intended force of the
// hand; B [N s/m]: virtual damping; d [s]: additional delay; r [m]: resolution of positions; c [N]: Coulomb friction.
//   Colgate and Schenkel 1997     b > K T / 2 + |B|      sufficient for every operator, if b is the device's alone
//   Hulin et al. 2006, 2014       b + B > K (T / 2 + d)  linear condition for small K T^2 / m
//   Abbott and Okamura 2005;      c >= K r / 2           rounded positions generate no energy; with c = 0 no K
//   Diolaiti et al. 2006                                 satisfies this, and limit cycles of a few steps r remain
//   Jury                          the exact limit of the linear loop at d = 0, B = 0: both eigenvalues of the map over
//                                 one frame lie inside the unit circle
// J. E. Colgate, G. Schenkel, J. Robotic Systems 14(1), 37-47, 1997. T. Hulin, C. Preusche, G. Hirzinger, IROS 2006;
// T. Hulin, A. Albu-Schaeffer, G. Hirzinger, IEEE Trans. Control Systems Technology 22(4), 1297-1309, 2014.
// J. J. Abbott, A. M. Okamura, IEEE Trans. Robotics 21(5), 952-964, 2005. N. Diolaiti, G. Niemeyer, F. Barbagli,
// J. K. Salisbury, IEEE Trans. Robotics 22(2), 256-268, 2006.

#include <limits>

namespace forefeel {

// A device together with the hand that holds it. NaN: not known.
struct LoopPlant {
  double mass = std::numeric_limits<double>::quiet_NaN();       // m [kg]
  double damping = std::numeric_limits<double>::quiet_NaN();    // b [N s/m]
  double stiffness = std::numeric_limits<double>::quiet_NaN();  // k [N/m]
  double resolution = 0;                                        // r [m]
  double friction = 0;                                          // c [N]
};

// K [N/m] of the results above; frame: T [s], delay: d [s], virtual_damping: B [N s/m].
double colgate_limit(const LoopPlant& plant, double frame, double virtual_damping = 0);
double hulin_limit(const LoopPlant& plant, double frame, double delay = 0, double virtual_damping = 0);
double friction_limit(const LoopPlant& plant);  // infinite at r = 0
// The exact limit (Jury); NaN if mass, damping or stiffness is not known.
double sampled_limit(const LoopPlant& plant, double frame);

}  // namespace forefeel
