#pragma once
// Keeps the loop passive while models change. It is part of the safety rules, so it counts the energy of the force that
// is sent, after force limit and slew limit. f [N]: force before these limits, x [m]: measured tip, F [N]: force sent.
//   coupling   f <- s f,  s = min(1, K_c / K),  K [N/m]: largest stiffness of the newest model at x. For a linear body
//              this is a virtual coupling by a spring K_vc in series, 1 / K_vc = 1 / K_c - 1 / K, with the proxy at
//              the place where both forces agree. K_c is below the stability limit (motion/loop_limit.hpp). s falls at
//              once and rises with the time constant `recovery`. It also falls by 5 % in each frame in which the slew
//              limit acts, because a force that lags generates energy.
//   tank       E [J]: energy that the hand has put in and not got back, by the trapezoid rule (record/stability.hpp)
//                E <- min(E - (F + F_before) . dx / 2, |f|max |x|)
//              U [J]: energy that the model gives back on the straight path from x to rest, by Simpson's rule. A switch
//              that raises U above E would generate energy.
//              f <- g f. While the tip moves out, g follows min(1, 2 (E + q) / U): it falls at once and rises with
//              `recovery`. So the force fades on the way out, and E + q stays above zero; the force need not be
//              removed at rest. While the hand presses in, g rises towards 1 with the work of the hand.
//   controller F <- F - a dx with the smallest a that keeps E + q >= 0, as far as force and slew limit allow
//              (Hannaford and Ryu 2002).
// q [J]: dead zone of one quantum of the encoder, sqrt(3) r |f|max, because the rounding of positions is not energy of
// the loop. Energy tanks: F. Ferraguti, C. Secchi, C. Fantuzzi, ICRA 2013. Virtual coupling: J. E. Colgate, M. C.
// Stanley, J. M. Brown, IROS 1995. Nothing here allocates, locks or throws.

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

  // The newest model at x; taken: it is new in this frame. Call this when a model is taken, and every few frames.
  void note_model(const Vec3& x, const ModelView& model, bool taken) noexcept;
  // f: after guard, watchdog and ramp, before the force limit. Returns s g f.
  Vec3 shape(const Vec3& force, const Vec3& x) noexcept;
  // force: within the limits of `room`. Returns F, also within them.
  Vec3 settle(const Vec3& force, const Vec3& x, const ForceRoom& room) noexcept;
  // Replaces settle() while the force is prescribed: during the ramp at the end.
  void account(const Vec3& sent, const Vec3& x, const Vec3& before) noexcept;
  // Called in each frame. True if note_model() is due: from the eighth frame after its last call.
  bool wants_model() noexcept { return ++since_ >= 8; }

  const PassivityReport& report() const { return report_; }

 private:
  double quantum() const noexcept { return 1.7320508075688772 * options_.resolution * most_; }
  Vec3 step_to(const Vec3& x) noexcept;

  PassivityOptions options_;
  double rise_;                                   // share of the missing gain that is regained in a frame
  double coupling_ = 1, gain_ = 1;                // s, g
  double stiffness_ = 0, share_ = 0.5;            // K [N/m]; U / (-f . x) [1]
  double energy_ = 0, potential_ = 0, most_ = 0;  // E [J], U [J], |f|max [N]
  Vec3 last_x_ = Vec3::Zero();
  bool begun_ = false;
  int since_ = 1 << 20;
  PassivityReport report_;
};

}  // namespace forefeel
