#include "geometry/states/force_trend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr std::size_t fewest = 6;        // states
constexpr double least_spread = 0.1;     // of the largest deviation: a direction in which positions spread
constexpr double least_explained = 0.5;  // of the variance of the forces
constexpr double clearly = 0.1;          // of the largest eigenvalue
constexpr double not_symmetric = 0.5;    // |K - K^T| / |K + K^T|
constexpr std::size_t fewest_skew = 20;  // states that show it
constexpr double at_rest = 1e-6;         // [m]
constexpr double rounding = 1e-9;        // of the largest eigenvalue
constexpr double sure_of_offset = 4;     // standard errors
constexpr std::size_t around = 12;       // states that tell the noise at rest
constexpr double offset = 0.01, offset_share = 0.02;  // of a sensor: [N], of the largest force

struct Trend {
  Eigen::MatrixXd along;  // directions in which the positions spread, in columns
  Mat3 slope;             // df/dx; 0 across them
  double explained = 0;
};

Trend trend_of(std::span<const State* const> states) {
  const auto n = static_cast<double>(states.size());
  Vec3 middle = Vec3::Zero(), mean = Vec3::Zero();
  for (const State* s : states) middle += s->at / n, mean += s->force / n;
  Mat3 spread = Mat3::Zero(), both = Mat3::Zero();
  double all = 0;
  for (const State* s : states) {
    const Vec3 x = s->at - middle, f = s->force - mean;
    spread += x * x.transpose();
    both += f * x.transpose();
    all += f.squaredNorm();
  }
  const Modes3 modes = axes_of(spread);
  Trend trend{.along = Eigen::MatrixXd(3, 0), .slope = Mat3::Zero()};
  for (int k = 2; k >= 0 && modes.values[k] > least_spread * least_spread * modes.values[2]; --k) {
    const Vec3 u = modes.vectors.col(k);
    trend.along.conservativeResize(3, trend.along.cols() + 1);
    trend.along.rightCols(1) = u;
    trend.slope += both * u * u.transpose() / modes.values[k];
  }
  trend.explained = all > 0 ? (trend.slope.transpose() * both).trace() / all : 0;
  return trend;
}

// Column i of the force is `sign[i]` times column `from[i]` of the file.
struct Columns {
  std::array<int, 3> from{0, 1, 2}, sign{1, 1, 1};
  std::string text() const {
    constexpr std::array names{"fx", "fy", "fz"};
    std::string text = "x,y,z";
    for (std::size_t i = 0; i < 3; ++i)
      text += fmt::format(",{}{}", sign[i] < 0 ? "-" : "", names[static_cast<std::size_t>(from[i])]);
    return text;
  }
  bool turned() const { return std::ranges::count(sign, -1) == 3 && std::ranges::is_sorted(from); }
};

// The least eigenvalue of K with these columns, over the largest; and how far K is from symmetric.
struct Stability {
  double least = 0, skew = 0, lowest = 0, highest = 0;
};
Stability stability_of(const Trend& trend, const Columns& columns) {
  Mat3 slope;
  for (int i = 0; i < 3; ++i)
    slope.row(i) = columns.sign[static_cast<std::size_t>(i)] *
                   trend.slope.row(columns.from[static_cast<std::size_t>(i)]);
  const Eigen::MatrixXd k = -trend.along.transpose() * slope * trend.along;
  const Eigen::VectorXd values = modes_of(0.5 * (k + k.transpose())).values;
  const double most = values.cwiseAbs().maxCoeff();
  const auto digits = [&](double value) { return std::abs(value) > rounding * most ? value : 0; };
  return {.least = values.minCoeff() / most,
          .skew = (k - k.transpose()).norm() / std::max((k + k.transpose()).norm(), 1e-300),
          .lowest = digits(values.minCoeff()),
          .highest = digits(values.maxCoeff())};
}

// Deviation of a component [N] from the plane through the states nearest to rest; 0: too few to tell.
double noise_near_rest(std::vector<const State*> states) {
  const std::size_t n = std::min(around, states.size());
  if (n < around / 2 + 2) return 0;
  std::ranges::nth_element(states, states.begin() + static_cast<std::ptrdiff_t>(n) - 1, {},
                           [](const State* s) { return s->at.squaredNorm(); });
  states.resize(n);
  const Trend trend = trend_of(states);
  Vec3 mean = Vec3::Zero();
  for (const State* s : states) mean += s->force / static_cast<double>(n);
  double all = 0;
  for (const State* s : states) all += (s->force - mean).squaredNorm();
  return std::sqrt(std::max(0.0, 1 - trend.explained) * all / (3 * static_cast<double>(n - 4)));
}

std::string turned_forces(std::span<const State* const> states) {
  const Trend trend = trend_of(states);
  if (trend.along.cols() == 0 || !(trend.explained > least_explained)) return {};
  const Stability as_given = stability_of(trend, {});
  const bool pulls = as_given.least < -clearly;
  if (!pulls && !(as_given.skew > not_symmetric && states.size() >= fewest_skew)) return {};
  Columns best;
  double best_score = clearly;
  for (std::array from{0, 1, 2};;) {
    for (int bits = 0; bits < 8; ++bits) {
      const Columns columns{.from = from, .sign = {bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1}};
      const Stability tried = stability_of(trend, columns);
      const double score =
          tried.least - tried.skew + (columns.turned() ? 2 * clearly : 0);  // the likeliest mistake
      if (score > best_score) best = columns, best_score = score;
    }
    if (!std::ranges::next_permutation(from).found) break;
  }
  if (best_score <= clearly) return {};
  const std::string seen =
      pulls ? fmt::format(
                  "the forces pull where an elastic body pushes back (-df/dx fitted to all: {:.3g} to "
                  "{:.3g} N/m)",
                  as_given.lowest, as_given.highest)
            : fmt::format(
                  "the forces turn about the displacement, as those of no elastic body do (the part of "
                  "-df/dx that is not symmetric is {:.3g} of the other)",
                  as_given.skew);
  return best.turned()
             ? seen + "; if they are those on the tissue, import --columns " + best.text() + " turns them"
             : seen + "; if axes are exchanged or turned, import --columns " + best.text() + " mends it";
}

}  // namespace

std::vector<std::string> contrary_forces(std::span<const State> states) {
  std::vector<const State*> given;
  double largest = 0;
  for (const State& s : states) {
    if (!s.usable() || !s.force.allFinite() || s.has_site()) continue;
    given.push_back(&s);
    largest = std::max(largest, s.force.norm());
  }
  std::vector<std::string> lines;
  if (given.size() < fewest) return lines;
  if (std::string line = turned_forces(given); !line.empty()) lines.push_back(std::move(line));
  const auto rest = std::ranges::find_if(given, [](const State* s) { return s->at.norm() < at_rest; });
  if (rest != given.end() && (*rest)->force.norm() > std::max({offset, offset_share * largest,
                                                               sure_of_offset * noise_near_rest(given)}))
    lines.push_back(
        fmt::format("the force at rest (0,0,0) is {:g},{:g},{:g} N, expected 0; if the sensor was not tared, "
                    "subtract it from all rows",
                    (*rest)->force.x(), (*rest)->force.y(), (*rest)->force.z()));
  return lines;
}

}  // namespace forefeel
