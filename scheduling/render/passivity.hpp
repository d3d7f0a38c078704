#pragma once
// Keeps the loop passive while models change. It is one of the safety rules, so it counts the energy of the force that
// is sent, after force limit and slew limit. f [N]: force before these limits, x [m]: measured tip, F [N]: force sent.
//   coupling   f <- s f,  s = min(1, K_c / K),  K [N/m]: largest stiffness of the newest model at x. For a linear body
//              this is a virtual coupling by a spring K_vc in series, 1 / K_vc = 1 / K_c - 1 / K, with the proxy at
//              the place where both forces agree. K_c is below the stability limit (motion/loop_limit.hpp). s falls at
//              once and rises with the time constant `recovery`. It also falls by 1 % in each frame in which the slew
//              limit acts, because a force that lags generates energy.
//   tank       E [J]: energy that the hand has put in and not got back, by the trapezoid rule (record/stability.hpp)
//                E <- min(E - (F + F_before) . dx / 2, |F|max |x|),   |F|max: largest force sent so far [N]
//   reserve    F <- g F with the largest g in [0, 1] that leaves
//                E + q >= |F|^2 / (2 K_b),   K_b = min(K_c, S / v)    [N/m]
//              S [N/s]: slew limit. v [m/s]: twice the highest smoothed speed of the tip in about the last 0.3 s. A
//              force that falls to zero at the slew limit, while the tip moves along it at v, returns v |F|^2 / (2 S).
//              If the tank holds that much and the tip is not faster than v, the tank holds enough again one frame
//              later, with the force lowered by S T, since (|F| + |F'|) v T / 2 = v (|F|^2 - |F'|^2) / (2 S). So the
//              tank is never empty before the force is zero. Where the rule lowers the force, F is that of a spring
//              K_b that stores E + q: the way in and the way out agree, and a loop with K_b <= K_c is stable.
//   way out    U [J]: energy that the model gives back on the straight path from x to rest, by Simpson's rule. A switch
//              that raises U above E would generate energy. While the tip moves out, also g <= 2 (E + q) / U, so that
//              the force fades early.
//   controller F <- F - a dx with the smallest a that keeps E + q >= 0, as far as force and slew limit allow
//              (Hannaford and Ryu 2002). It acts where the tip was faster than v.
// g has no memory: a g that rises slowly made oscillations grow in 1 to 65 of 504 simulated loops; without memory they
// grew in none. The price: the hand stores |F|^2 / (2 K) in a spring K. So a hand faster than S / (2 K) feels a spring
// softer than K. And a force that appears without work of the hand, as after a switch of models, stays small until the
// hand presses further.
// Where a body is touched anywhere, |x| and "rest" count from the site of the touch (rest_at()), and without a touch
// from the tip itself: then the tank is empty.
// q [J]: dead zone of one quantum of the encoder, sqrt(3) r |F|max, because the rounding of positions is not energy of
// the loop. Energy tanks: F. Ferraguti, C. Secchi, C. Fantuzzi, ICRA 2013. Virtual coupling: J. E. Colgate, M. C.
// Stanley, J. M. Brown, IROS 1995. The reserve follows from the equations above. Nothing here allocates, locks or
// throws.

#include "geometry/common/types.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/render/render_options.hpp"

namespace forefeel {

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

  // The place of the tip without force; zero until it is called.
  void rest_at(const Vec3& rest) noexcept { tank_.rest = rest; }
  // The newest model at x; taken: it is new in this frame. Call this when a model is taken, and every few frames.
  void note_model(const Vec3& x, const ModelView& model, bool taken) noexcept;
  // f: after guard, watchdog and ramp, before the force limit. Returns s f.
  Vec3 shape(const Vec3& force, const Vec3& x) noexcept;
  // force: within the limits of `room`. Returns F, also within them.
  Vec3 settle(const Vec3& force, const Vec3& x, const ForceRoom& room) noexcept;
  // Replaces settle() while the force is prescribed: during the ramp at the end.
  void account(const Vec3& sent, const Vec3& x, const Vec3& before) noexcept;
  // Called in each frame. True if note_model() is due: from the eighth frame after its last call.
  bool wants_model() noexcept { return ++since_ >= 8; }

  const PassivityReport& report() const { return report_; }

 private:
  struct Tank {
    double energy = 0, potential = 0, most_sent = 0;  // E [J], U [J], |F|max [N]
    Vec3 rest = Vec3::Zero();                         // [m]
  };
  struct Motion {
    Vec3 last_x = Vec3::Zero(), smooth_step = Vec3::Zero();  // [m]
    double smooth_room = 0;                                  // of the steps of force [N]
    double softest = 0;                                      // v / S, highest of the last while [m/N]
    bool begun = false;
  };

  double quantum() const noexcept { return 1.7320508075688772 * options_.resolution * tank_.most_sent; }
  Vec3 step_to(const Vec3& x) const noexcept {
    return motion_.begun ? Vec3(x - motion_.last_x) : Vec3::Zero();
  }
  void note_speed(const Vec3& dx, double room) noexcept;
  double paid_share(const Vec3& force, const Vec3& dx, const Vec3& before) const noexcept;

  PassivityOptions options_;
  double frame_;                        // [s]
  double coupling_ = 1, gain_ = 1;      // s, g
  double stiffness_ = 0, share_ = 0.5;  // K [N/m]; U / (-f . x) [1]
  Tank tank_;
  Motion motion_;
  int since_ = 1 << 20;
  PassivityReport report_;
};

}  // namespace forefeel
