#include "apps/bench/viscous_curves.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace forefeel {
namespace {

// Numbers of the frames that are shown: 0 and then evenly in the logarithm of time up to five times the longest one.
std::vector<std::size_t> shown_frames(const Viscosity& viscosity, double frame, std::size_t points) {
  double longest = 0;
  for (const MaxwellBranch& branch : viscosity) longest = std::max(longest, branch.time);
  const double last = std::max(10.0, 5 * longest / frame);
  std::vector<std::size_t> frames{0};
  for (std::size_t i = 0; i < points; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(points - 1);
    const auto k = static_cast<std::size_t>(std::llround(std::pow(last, share)));
    if (k > frames.back()) frames.push_back(k);
  }
  return frames;
}

// The elastic force for which the filter gives `wanted` in its next step. The filter is linear.
double elastic_for(const RelaxationFilter& filter, double wanted, double frame) {
  RelaxationFilter none = filter, one = filter;
  const double without = none.step(Vec3::Zero(), frame).x(), with = one.step(Vec3::UnitX(), frame).x();
  return (wanted - without) / (with - without);
}

}  // namespace

ElasticLine::ElasticLine(std::span<const State> states, const Vec3& n) {
  for (const State& state : states) {
    depths_.push_back(state.at.dot(n));
    forces_.push_back(-state.force.dot(n));
    slopes_.push_back(n.dot(state.stiffness * n));
  }
}

std::size_t ElasticLine::interval(double s) const {
  const auto above = std::upper_bound(depths_.begin() + 1, depths_.end() - 1, s) - depths_.begin();
  return static_cast<std::size_t>(above) - 1;
}

double ElasticLine::force(double s) const {
  const std::size_t i = interval(s);
  const double h = depths_[i + 1] - depths_[i], u = (s - depths_[i]) / h;
  return (1 + 2 * u) * (1 - u) * (1 - u) * forces_[i] + u * u * (3 - 2 * u) * forces_[i + 1] +
         h * u * (1 - u) * ((1 - u) * slopes_[i] - u * slopes_[i + 1]);
}

double ElasticLine::slope(double s) const {
  const std::size_t i = interval(s);
  const double h = depths_[i + 1] - depths_[i], u = (s - depths_[i]) / h;
  return 6 * u * (1 - u) * (forces_[i + 1] - forces_[i]) / h + (1 - u) * (1 - 3 * u) * slopes_[i] +
         u * (3 * u - 2) * slopes_[i + 1];
}

double ElasticLine::place(double f) const {
  double low = 0, high = depth();
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (force(middle) < f ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double ViscousCurve::largest() const {
  double most = 0, size = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    most = std::max(most, std::abs(filter[i] - exact[i]));
    size = std::max(size, std::abs(exact[i]));
  }
  return most / size;
}

double ViscousCurve::area(const std::vector<double>& y) const {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t next = (i + 1) % x.size();
    sum += 0.5 * (y[i] + y[next]) * (x[next] - x[i]);
  }
  return sum;
}

ViscousCurve relaxation_curve(const ElasticLine& line, const Viscosity& viscosity, double frame,
                              std::size_t points) {
  const Vec3 force(line.force(line.depth()), 0, 0);
  RelaxationFilter filter(viscosity);
  ViscousCurve curve;
  std::size_t k = 0;
  Vec3 now = filter.step(force, 0);
  for (const std::size_t shown : shown_frames(viscosity, frame, points)) {
    for (; k < shown; ++k) now = filter.step(force, frame);
    const double t = static_cast<double>(k) * frame;
    curve.x.push_back(t);
    curve.filter.push_back(now.x());
    curve.exact.push_back(relaxation(viscosity, t) * force.x());
  }
  return curve;
}

ViscousCurve creep_curve(const ElasticLine& line, const Viscosity& viscosity, double push, double frame,
                         std::size_t points) {
  const auto n = static_cast<Eigen::Index>(viscosity.size());
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n + 1, n + 1);
  Eigen::VectorXd start(n + 1);
  start[0] = push;
  for (Eigen::Index i = 0; i < n; ++i) {
    const MaxwellBranch& branch = viscosity[static_cast<std::size_t>(i)];
    start[i + 1] = push * branch.share;
    m(0, i + 1) = 1 / branch.time;
    for (Eigen::Index j = 0; j < n; ++j)
      m(i + 1, j + 1) =
          branch.share / viscosity[static_cast<std::size_t>(j)].time - (i == j ? 1 / branch.time : 0);
  }
  RelaxationFilter filter(viscosity);
  ViscousCurve curve;
  double elastic = push;
  filter.step(Vec3(elastic, 0, 0), 0);
  std::size_t k = 0;
  for (const std::size_t shown : shown_frames(viscosity, frame, points)) {
    for (; k < shown; ++k) {
      elastic = elastic_for(filter, push, frame);
      filter.step(Vec3(elastic, 0, 0), frame);
    }
    const double t = static_cast<double>(k) * frame;
    curve.x.push_back(t);
    curve.filter.push_back(line.place(elastic));
    const Eigen::MatrixXd passed = (m * t).exp();
    curve.exact.push_back(line.place(passed.row(0) * start));
  }
  return curve;
}

ViscousCurve hysteresis_loop(const ElasticLine& line, const Viscosity& viscosity, double period,
                             double frame) {
  // Gauss's rule of five points on [-1, 1].
  constexpr std::array nodes{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                             0.9061798459386640};
  constexpr std::array weights{0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                               0.2369268850561891};
  const double omega = 2 * M_PI / period, amplitude = 0.5 * line.depth();
  const auto s = [&](double t) { return amplitude * (1 - std::cos(omega * t)); };
  const auto per_period = static_cast<std::size_t>(std::llround(period / frame));
  RelaxationFilter filter(viscosity);
  std::vector<double> h(viscosity.size(), 0.0);
  ViscousCurve loop;
  loop.period = period;
  Vec3 now = filter.step(Vec3::Zero(), 0);
  for (std::size_t k = 1; k < 3 * per_period; ++k) {
    const double t = static_cast<double>(k) * frame;
    now = filter.step(Vec3(line.force(s(t)), 0, 0), frame);
    double exact = long_term_share(viscosity) * line.force(s(t));
    for (std::size_t b = 0; b < viscosity.size(); ++b) {
      h[b] *= std::exp(-frame / viscosity[b].time);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double u = t - frame * (1 - nodes[i]) / 2;
        h[b] += viscosity[b].share * 0.5 * frame * weights[i] * std::exp(-(t - u) / viscosity[b].time) *
                line.slope(s(u)) * amplitude * omega * std::sin(omega * u);
      }
      exact += h[b];
    }
    if (k < 2 * per_period) continue;
    loop.x.push_back(s(t));
    loop.filter.push_back(now.x());
    loop.exact.push_back(exact);
  }
  return loop;
}

}  // namespace forefeel
