#include "scheduling/render/passivity.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace forefeel {

std::string_view name(Passivity passivity) {
  return passivity == Passivity::control ? "control" : "observe";
}

namespace {

constexpr double lagging = 0.95;  // factor of s in a frame that the slew limit holds back

// The gain falls to `wanted` at once and rises by a share of the difference.
double followed(double gain, double wanted, double rise) {
  return wanted < gain ? wanted : gain + rise * (wanted - gain);
}

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
    : options_(options), rise_(1 - std::exp(-frame / options.recovery)) {
  report_.on = options.mode == Passivity::control;
  report_.coupling = options.coupling;
}

void PassivityControl::note_model(const Vec3& x, const ModelView& model, bool taken) noexcept {
  since_ = 0;
  stiffness_ = largest_stiffness(model.jacobian, options_.coupling);
  const double end = -model.here.dot(x), middle = -model.half_way.dot(x);
  // Simpson's rule against the energies of tight solves on a liver phantom, 60 places: within 1 % of U for the neo-Hookean
  // law; for St. Venant-Kirchhoff p50 1 %, p95 50 %, since a model of states near x is poor half way to rest. A wrong U
  // costs force or work of the controller; the tank's own energy E does not depend on it.
  share_ = end > 0 ? std::clamp((4 * middle / end + 1) / 6, 0.1, 1.0) : 0.5;
  if (!taken) return;
  const double now = stored_energy(coupling_ * model.here, x, share_, options_.force_limit);
  report_.refused += std::max(0.0, gain_ * now - std::max(energy_ + quantum(), gain_ * potential_));
}

Vec3 PassivityControl::shape(const Vec3& force, const Vec3& x) noexcept {
  const double s = stiffness_ > options_.coupling ? options_.coupling / stiffness_ : 1;
  coupling_ = followed(coupling_, s, rise_);
  const Vec3 coupled = coupling_ * force;
  potential_ = stored_energy(coupled, x, share_, options_.force_limit);
  most_ = std::max(most_, std::min(coupled.norm(), options_.force_limit));
  const double work = begun_ ? -coupled.dot(x - last_x_) : 0, room = energy_ + quantum();
  const double g = 2 * room >= potential_ ? 1 : std::max(0.0, 2 * room / potential_);
  if (work > 0)  // the hand presses in: its work fills the tank
    gain_ += (1 - gain_) * std::min(1.0, 4 * work / (potential_ + quantum()));
  else if (work < 0)
    gain_ = followed(gain_, g, rise_);
  report_.coupled += coupling_ < 0.999;
  report_.drained += gain_ < 0.999;
  report_.least_gain = std::min(report_.least_gain, coupling_ * gain_);
  return gain_ * coupled;
}

Vec3 PassivityControl::step_to(const Vec3& x) noexcept {
  const Vec3 dx = begun_ ? Vec3(x - last_x_) : Vec3::Zero();
  begun_ = true;
  last_x_ = x;
  return dx;
}

Vec3 PassivityControl::settle(const Vec3& force, const Vec3& x, const ForceRoom& room) noexcept {
  const Vec3 dx = begun_ ? Vec3(x - last_x_) : Vec3::Zero();
  Vec3 sent = force;
  if ((force - room.before).norm() >= room.step * (1 - 1e-9)) coupling_ *= lagging;
  const double after = energy_ - 0.5 * (force + room.before).dot(dx) + quantum();
  if (const double length = dx.squaredNorm(); after < 0 && length > 0) {
    sent = within(force + 2 * after / length * dx, room);
    ++report_.controlled;
    report_.dissipated += 0.5 * (force - sent).dot(dx);
  }
  account(sent, x, room.before);
  return sent;
}

void PassivityControl::account(const Vec3& sent, const Vec3& x, const Vec3& before) noexcept {
  const Vec3 dx = step_to(x);
  energy_ = std::min(energy_ - 0.5 * (sent + before).dot(dx), most_ * x.norm());
  report_.lowest = std::min(report_.lowest, energy_ + quantum());
}

}  // namespace forefeel
