#include "approx/measured/force_field.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "approx/measured/position_groups.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_rows = 1000;                     // of the process of all rows
constexpr std::size_t law_clusters = 64, cluster_rows = 4;  // rows that the law is fitted to
constexpr std::size_t law_boxes = 500;                      // that it is improved with
constexpr int polishing = 20;                               // steps
constexpr double least_apart = 0.1;                         // of boxes for a secant, in lengths and radii
constexpr std::size_t most_around = 2000;                   // rows that show which directions are known
constexpr std::size_t least_around = 12;
constexpr double least_across =
    0.05;  // in distances of the nearest row: less is the sag of a curve between rows
constexpr double known_share = 0.25;  // a direction is known up to the deviation of the rows divided by this
constexpr double surely = 2.8;        // 95 % of |e| lie within 2.8 deviations of a component (chi, 3 degrees)
constexpr double cone = 0.5;  // cosine of the angle to the direction across, within which rows tell of it
constexpr double most_overshoot = 2;  // no force is larger than this many times the largest known one

std::vector<Vec3> positions_of(std::span<const State> states) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  return at;
}

// Clusters of neighbouring states, evenly drawn: near ones show the noise, far ones the length of the field.
MeasuredRows rows_for_law(std::span<const State> states) {
  MeasuredRows rows;
  const std::vector<Vec3> at = positions_of(states);
  const PositionGroups groups = compact_groups(at, cluster_rows);
  const std::size_t stride = (groups.count + law_clusters - 1) / law_clusters;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (groups.of[i] % stride == 0) rows.add(states[i].at, states[i].force);
  return rows;
}

// The largest |F_i - F_j| / |x_i - x_j| of a box and the nearest box at least `apart` from it, less what noise makes.
double largest_secant(const MeasuredRows& boxes, double noise, double apart) {
  double most = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::size_t nearest = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      const double d = (boxes.at[j] - boxes.at[i]).norm();
      if (j != i && d >= apart && d < least) least = d, nearest = j;
    }
    if (nearest == i || !(least > 0)) continue;
    const double doubt = surely * noise * std::sqrt(1 / boxes.weight[i] + 1 / boxes.weight[nearest]);
    const double change = (boxes.force[nearest] - boxes.force[i]).norm() - doubt;
    most = std::max(most, change / least);
  }
  return most;
}

double radius_of(const MeasuredRows& rows) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : rows.at) middle += x / double(rows.size());
  double most = 0;
  for (const Vec3& x : rows.at) most = std::max(most, (x - middle).norm());
  return most;
}

}  // namespace

MeasuredRows averaged_boxes(std::span<const State> states, std::size_t most) {
  MeasuredRows rows;
  const std::vector<Vec3> at = positions_of(states);
  std::size_t size = 1;
  while (states.size() > size * most) size *= 2;
  const PositionGroups groups = compact_groups(at, size);
  rows.at.assign(groups.count, Vec3::Zero());
  rows.force.assign(groups.count, Vec3::Zero());
  rows.weight.assign(groups.count, 0);
  for (std::size_t i = 0; i < states.size(); ++i) {
    rows.at[groups.of[i]] += states[i].at;
    rows.force[groups.of[i]] += states[i].force;
    rows.weight[groups.of[i]] += 1;
  }
  for (std::size_t g = 0; g < groups.count; ++g)
    rows.at[g] /= rows.weight[g], rows.force[g] /= rows.weight[g];
  return rows;
}

std::optional<FieldOptions> field_of(std::span<const State> states, const KnownNoise& noise) {
  if (states.size() < 8) return {};
  const MeasuredRows some = rows_for_law(states), boxes = averaged_boxes(states, law_boxes);
  std::optional<LikelyLaw> best;
  const auto fit = [&](std::optional<double> known) {
    best.reset();
    for (const Smoothness smoothness : {Smoothness::gaussian, Smoothness::matern52, Smoothness::matern32}) {
      std::optional<LikelyLaw> found = likely_law(some, smoothness, known);
      if (found) found = improved_law(boxes, found->law, 0, known);
      if (found && (!best || found->minus_log_likelihood < best->minus_log_likelihood)) best = found;
    }
    if (best) best = improved_law(boxes, best->law, polishing, known);
  };
  fit(noise.force);
  if (!best) return {};
  // A position that is off by e changes the force by the slope times e.
  if (noise.position) {
    const double slope = best->law.amplitude / best->law.length;
    const double least = std::hypot(noise.force.value_or(0), slope * *noise.position);
    if (noise.force || best->law.noise < least) fit(least);
    if (!best) return {};
  }
  double most = 0;
  for (const Vec3& f : boxes.force) most = std::max(most, f.norm());
  const double apart = std::min(least_apart * best->law.length, least_apart * radius_of(boxes));
  return FieldOptions{
      .law = best->law,
      .stiffest = std::max(largest_secant(boxes, best->law.noise, apart), most / radius_of(boxes))};
}

ForceField::ForceField(const StateSpace& known, const FieldOptions& options)
    : known_(&known), options_(options) {
  std::vector<State> states;
  for (std::uint32_t id = 0; id < known.size(); ++id) {
    const State& state = known[StateId{id}];
    most_ = std::max(most_, state.force.norm());
    rows_.push_back(state.at);
    if (options.neighbours > 0) continue;
    State light;
    light.at = state.at;
    light.force = state.force;
    states.push_back(std::move(light));
  }
  if (options.neighbours == 0)
    all_ = std::make_shared<const GaussianProcess>(averaged_boxes(states, most_rows), options.law);
}

GaussianProcess::Prediction ForceField::predicted(const Vec3& x) const {
  if (all_) return all_->at(x);
  std::vector<StateId> ids;
  known_->nearest(x, options_.neighbours, ids);
  MeasuredRows rows;
  for (const StateId id : ids) rows.add((*known_)[id].at, (*known_)[id].force);
  return GaussianProcess(std::move(rows), options_.law).at(x);
}

ForceField::Foot ForceField::foot_of(const Vec3& x) const {
  std::vector<StateId> ids;
  known_->nearest(x, 1, ids);
  const double nearest = ((*known_)[ids.front()].at - x).norm();
  known_->within(x, 4 * nearest, ids);
  if (ids.size() < least_around) known_->nearest(x, least_around, ids);
  const std::size_t stride = ids.size() / most_around + 1;
  Vec3 middle = Vec3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < ids.size(); i += stride) middle += (*known_)[ids[i]].at - x, ++count;
  middle /= count;
  Mat3 spread = Mat3::Zero();
  for (std::size_t i = 0; i < ids.size(); i += stride) {
    const Vec3 off = (*known_)[ids[i]].at - x - middle;
    spread += off * off.transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
  Vec3 across = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = axes.eigenvectors().col(k);
    const double off = -u.dot(middle);
    if (known_share * std::abs(off) > std::sqrt(std::max(0.0, axes.eigenvalues()[k]))) across += off * u;
  }
  const Vec3 foot = x - across;
  if (across.norm() <= least_across * nearest || known_across(x, foot)) return {.at = x, .across = 0};
  return {.at = foot, .across = across.norm()};
}

bool ForceField::known_across(const Vec3& x, const Vec3& foot) const {
  const double across = (x - foot).norm();
  const Vec3 u = (x - foot) / across;
  const auto tells = [&](const Vec3& from, const Vec3& towards) {
    const double away = from.norm();
    return away >= across && away <= options_.law.length && from.dot(towards) >= cone * away;
  };
  for (const Vec3& at : rows_)
    if (tells(at - x, u) || tells(at - foot, -u)) return true;
  return false;
}

ForceField::Prediction ForceField::at(const Vec3& x) const {
  const Foot foot = foot_of(x);
  const GaussianProcess::Prediction own = predicted(foot.at);
  Prediction made{.force = own.force,
                  .deviation = std::sqrt(3.0) * own.deviation,
                  .foot = foot.at,
                  .least_error = options_.stiffest * foot.across};
  const double size = made.force.norm();
  if (size > bound()) made.force *= bound() / size;
  return made;
}

double ForceField::bound() const {
  return most_overshoot * most_;
}

}  // namespace forefeel
