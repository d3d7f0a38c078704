#pragma once
// Keeps the loop passive while models change. It stands among the safety rules: what it sees is what is sent, after
// force limit and slew limit. With f [N] the force that they ask for, x [m] the measured tip, F [N] the force sent:
//   coupling   f <- s f,  s = min(1, K_c / K),  K [N/m] largest stiffness of the newest model at x. For a linear body
//              this is a virtual coupling of a spring K_vc in series, 1 / K_vc = 1 / K_c - 1 / K, with the proxy at
//              the place where both forces agree; K_c is below the boundary of stability (motion/loop_limit.hpp).
//              s falls at once, by 5 % also where the slew limit acts (lag generates), and rises within `recovery`.
//   tank       E [J]: what the hand put in and did not get back, by the trapezoid rule, as the verdict counts it
//                E <- min(E - (F + F_before) . dx / 2, |f|max |x|)         (record/stability.hpp)
//              U [J]: what the model gives back on a straight way to rest, - integral of f . dx by Simpson's rule. A
//              switch that raises U above E is one that would generate energy: the model gives more than it was given.
//              f <- g f,  g = min(1, 2 (E + q) / U), falls at once, rises with `recovery`: the force fades on the
//              way out, so that E + q stays above zero, instead of being taken away at rest.
//   controller F <- F - a dx with the smallest a that keeps E + q >= 0, as far as force and slew limit allow
//              (Hannaford and Ryu 2002, Eqs. 4 and 5).
// q [J]: dead zone, one quantum of the encoder, sqrt(3) r |F|max: rounded positions are no energy. Energy tanks:
// F. Ferraguti, C. Secchi, C. Fantuzzi, ICRA 2013. Virtual coupling: J. E. Colgate, M. C. Stanley, J. M. Brown,
// IROS 1995. Nothing here allocates, locks or throws.

#include <limits>
#include <string_view>

#include "geometry/common/types.hpp"
#include "scheduling/log/passivity_report.hpp"

namespace forefeel {

enum class Passivity { observe, control };
std::string_view name(Passivity passivity);

struct PassivityOptions {
  Passivity mode = Passivity::observe;
  double coupling = std::numeric_limits<double>::infinity();     // K_c [N/m]
  double resolution = 0;                                         // r [m]
  double force_limit = std::numeric_limits<double>::infinity();  // [N]
  double recovery = 1;                                           // time constant with which gains rise [s]
};

struct ModelView {
  Vec3 here = Vec3::Zero(), half_way = Vec3::Zero();  // force at x and half way to rest [N]
  Mat3 jacobian = Mat3::Zero();                       // of the force at x [N/m]
};

// The limits of a frame's force.
struct ForceRoom {
  Vec3 before = Vec3::Zero();  // sent in the frame before [N]
  double step = 0;             // largest |F - before| [N]
  double size = 0;             // largest |F| [N]
};

class PassivityControl {
 public:
  PassivityControl(const PassivityOptions& options, double frame);  // frame [s]

  // What the newest model says at x, and whether it was taken in this frame. To be called when it is taken, and
  // every few frames.
  void note_model(const Vec3& x, const ModelView& model, bool taken) noexcept;
  // f: after guard, watchdog and ramp, before the force limit. Returns s g f.
  Vec3 shape(const Vec3& force, const Vec3& x) noexcept;
  // force: within the limits. Returns F, within them.
  Vec3 settle(const Vec3& force, const Vec3& x, const ForceRoom& room) noexcept;
  // Instead of settle() where the force is fixed: the ramp at the end.
  void account(const Vec3& sent, const Vec3& x, const Vec3& before) noexcept;
  // Whether note_model() is due.
  bool wants_model() noexcept { return ++since_ >= 8; }

  const PassivityReport& report() const { return report_; }

 private:
  double quantum() const noexcept { return 1.7320508075688772 * options_.resolution * most_; }
  Vec3 step_to(const Vec3& x) noexcept;

  PassivityOptions options_;
  double rise_;                                   // of a gain in a frame
  double coupling_ = 1, gain_ = 1;                // s, g
  double stiffness_ = 0, share_ = 0.5;            // K; U / (-f . x)
  double energy_ = 0, potential_ = 0, most_ = 0;  // E, U, |F|max
  Vec3 last_x_ = Vec3::Zero();
  bool begun_ = false;
  int since_ = 1 << 20;
  PassivityReport report_;
};

}  // namespace forefeel
