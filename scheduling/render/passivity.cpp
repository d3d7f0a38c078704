#include "scheduling/render/passivity.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace forefeel {

std::string_view name(Passivity passivity) {
  return passivity == Passivity::control ? "control" : "observe";
}

namespace {

constexpr double lagging = 0.99;         // factor of s in a frame that the slew limit holds back
constexpr double reserve = 2;            // v over the highest smoothed speed [1]
constexpr double newest_share = 0.3;     // of a step in the smoothed one [1]
constexpr double memory_of_speed = 0.3;  // [s]

// Largest eigenvalue of the symmetric part of -jacobian [N/m]. Returns 0 if the Frobenius norm, an upper bound of the
// eigenvalue, does not exceed `enough`.
double largest_stiffness(const Mat3& jacobian, double enough) noexcept {
  const double bound = jacobian.norm();
  if (!(bound > enough) || !std::isfinite(bound)) return 0;
  const Mat3 stiffness = -0.5 * (jacobian + jacobian.transpose());
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(stiffness, Eigen::EigenvaluesOnly);
  return std::max(0.0, solver.eigenvalues()[2]);
}

// U [J] of a force f [N] at x, at most `limit` [N] of which is sent. share: U / (-f . x) without the limit.
double stored_energy(const Vec3& force, const Vec3& x, double share, double limit) noexcept {
  const double size = force.norm(), work_home = std::max(0.0, -force.dot(x));
  return size > limit ? work_home * limit / size * (1 - (1 - share) * limit / size) : share * work_home;
}

Vec3 within(const Vec3& force, const ForceRoom& room) {
  Vec3 out = force;
  if (const double size = out.norm(); size > room.size) out *= room.size / size;
  const Vec3 step = out - room.before;
  if (const double size = step.norm(); size > room.step) out = room.before + room.step / size * step;
  return out;
}

}  // namespace

PassivityControl::PassivityControl(const PassivityOptions& options, double frame)
    : options_(options), frame_(frame) {
  report_.on = options.mode == Passivity::control;
  report_.coupling = options.coupling;
}

void PassivityControl::note_model(const Vec3& x, const ModelView& model, bool taken) noexcept {
  since_ = 0;
  stiffness_ = largest_stiffness(model.jacobian, options_.coupling);
  const Vec3 from_rest = x - tank_.rest;
  const double end = -model.here.dot(from_rest), middle = -model.half_way.dot(from_rest);
  // Simpson's rule against the energies of tight solves on a liver phantom, 60 places: within 1 % of U for the
  // neo-Hookean law; for St. Venant-Kirchhoff p50 1 %, p95 50 %, since a model of states near x is poor half way to
  // rest. A wrong U costs force or work of the controller; the tank's own energy E does not depend on it.
  share_ = end > 0 ? std::clamp((4 * middle / end + 1) / 6, 0.1, 1.0) : 0.5;
  if (!taken) return;
  const double now = stored_energy(coupling_ * model.here, from_rest, share_, options_.force_limit);
  report_.refused += std::max(0.0, gain_ * now - std::max(tank_.energy + quantum(), gain_ * tank_.potential));
}

Vec3 PassivityControl::shape(const Vec3& force, const Vec3& x) noexcept {
  const double s = stiffness_ > options_.coupling ? options_.coupling / stiffness_ : 1;
  coupling_ = s < coupling_ ? s : coupling_ + (1 - std::exp(-frame_ / options_.recovery)) * (s - coupling_);
  const Vec3 coupled = coupling_ * force;
  tank_.potential = stored_energy(coupled, x - tank_.rest, share_, options_.force_limit);
  report_.coupled += coupling_ < 0.999;
  return coupled;
}

// room: largest step of the force in this frame [N].
void PassivityControl::note_speed(const Vec3& dx, double room) noexcept {
  motion_.smooth_step += newest_share * (dx - motion_.smooth_step);
  motion_.smooth_room =
      motion_.begun ? motion_.smooth_room + newest_share * (room - motion_.smooth_room) : room;
  const double now = motion_.smooth_room > 0 ? motion_.smooth_step.norm() / motion_.smooth_room : 0;
  motion_.softest = std::max(now, std::exp(-frame_ / memory_of_speed) * motion_.softest);
}

// The largest g in [0, 1] with E' + q >= g^2 |F|^2 / (2 K_b), where E' = E - (g F + F_before) . dx / 2.
double PassivityControl::paid_share(const Vec3& force, const Vec3& dx, const Vec3& before) const noexcept {
  const double softness = std::max(1 / options_.coupling, reserve * motion_.softest);  // 1 / K_b
  const double a = 0.5 * force.squaredNorm() * softness, b = 0.5 * force.dot(dx);
  const double left = tank_.energy + quantum() - 0.5 * before.dot(dx);
  if (a + b <= left) return 1;
  const double root = b * b + 4 * a * left;
  if (!(a > 0))
    return b > 0 ? std::clamp(left / b, 0.0, 1.0) : 0;  // no limit of stiffness, the tip was at rest
  return root >= 0 ? std::clamp((std::sqrt(root) - b) / (2 * a), 0.0, 1.0) : 0;
}

Vec3 PassivityControl::settle(const Vec3& force, const Vec3& x, const ForceRoom& room) noexcept {
  const Vec3 dx = step_to(x);
  note_speed(dx, room.step);
  if ((force - room.before).norm() >= room.step * (1 - 1e-9)) coupling_ *= lagging;
  gain_ = paid_share(force, dx, room.before);
  const double home = std::max(0.0, 2 * (tank_.energy + quantum()));
  if (force.dot(dx) > 0 && tank_.potential > home) gain_ = std::min(gain_, home / tank_.potential);
  report_.drained += gain_ < 0.999;
  report_.least_gain = std::min(report_.least_gain, coupling_ * gain_);
  Vec3 sent = gain_ < 1 ? within(gain_ * force, room) : force;
  const double after = tank_.energy - 0.5 * (sent + room.before).dot(dx) + quantum();
  if (const double length = dx.squaredNorm(); after < 0 && length > 0) {
    const Vec3 damped = within(sent + 2 * after / length * dx, room);
    ++report_.controlled;
    report_.dissipated += 0.5 * (sent - damped).dot(dx);
    sent = damped;
  }
  account(sent, x, room.before);
  return sent;
}

void PassivityControl::account(const Vec3& sent, const Vec3& x, const Vec3& before) noexcept {
  const Vec3 dx = step_to(x);
  motion_.begun = true;
  motion_.last_x = x;
  tank_.most_sent = std::max(tank_.most_sent, sent.norm());
  tank_.energy =
      std::min(tank_.energy - 0.5 * (sent + before).dot(dx), tank_.most_sent * (x - tank_.rest).norm());
  report_.lowest = std::min(report_.lowest, tank_.energy + quantum());
}

}  // namespace forefeel
