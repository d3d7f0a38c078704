#include "approx/measured/force_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/common/dense.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/index/point_octree.hpp"
#include "geometry/states/heaps.hpp"

namespace forefeel {
namespace {

constexpr double rows_apart = 0.25;        // of the rows about a place, in their distances from it
constexpr double most_even = 8;            // radius of even rows about a place, in their median spacing
constexpr std::size_t most_tried = 40;     // of the rows nearest to a place, in those that are used
constexpr int local_steps = 15;            // of the search for the law of a place
constexpr std::size_t most_around = 2000;  // rows that show which directions are known
constexpr std::size_t least_around = 12;
constexpr double known_share = 0.25;  // a direction is known up to the deviation of the rows divided by this
constexpr double thin = 0.2;      // deviation of a thin direction, in the largest of the rows about a place
constexpr double surely_off = 2;  // standard errors of where rows lie, within which a place is among them
constexpr double cone = 0.5;      // cosine of the angle to the direction across, within which rows tell of it
constexpr double most_across =
    10;  // distances across, within which rows beyond tell of the direction at any l
constexpr double most_overshoot = 2;  // no force is larger than this many times the largest known one

double median_spacing(const std::vector<Vec3>& at) {
  std::vector<double> nearest(at.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double d = (at[i] - at[j]).squaredNorm();
      nearest[i] = std::min(nearest[i], d);
      nearest[j] = std::min(nearest[j], d);
    }
  return std::sqrt(median(std::move(nearest)));
}

// Where rows lie across themselves, from x, and how far they are from there.
struct Lie {
  double off = 0, deviation = 0;  // [m]
  double doubt = 0;               // of off: its standard error [m]
};

// Rows of a curve bend: their coordinate `axis` is a parabola of the one along them (axis 2), that of least squares.
// near: from x.
Lie lie_of(const std::vector<Vec3>& near, int axis) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vec3 right = Vec3::Zero();
  double size = 0, first = std::numeric_limits<double>::infinity(), last = -first;
  for (const Vec3& r : near) {
    size = std::max(size, r.norm());
    first = std::min(first, r[2]);
    last = std::max(last, r[2]);
  }
  const auto powers = [size](double t) { return Vec3(1, t / size, t * t / (size * size)); };
  for (const Vec3& r : near) {
    normal += powers(r[2]) * powers(r[2]).transpose();
    right += r[axis] * powers(r[2]);
  }
  const Mat3 inverse = pseudo_inverse(normal);
  const Vec3 parabola = inverse * right, here = powers(std::clamp(0.0, first, last));
  double squared = 0;
  for (const Vec3& r : near) squared += std::pow(r[axis] - parabola.dot(powers(r[2])), 2);
  Lie lie{.off = parabola.dot(here),
          .deviation = std::sqrt(squared / std::max(1.0, double(near.size()) - 3))};
  lie.doubt = lie.deviation * std::sqrt(std::max(0.0, here.dot(inverse * here)));
  return lie;
}

}  // namespace

ForceField::ForceField(const StateSpace& known, const FieldOptions& options)
    : known_(&known), options_(options) {
  std::vector<State> states;
  for (std::uint32_t id = 0; id < known.size(); ++id) {
    const State& state = known[StateId{id}];
    most_ = std::max(most_, state.force.norm());
    State light;
    light.at = state.at;
    light.force = state.force;
    states.push_back(std::move(light));
  }
  // A dwell among few other rows would hide which directions these know.
  if (std::vector<State> even = thinned_heaps(states); even.size() < states.size()) {
    const auto space = std::make_shared<StateSpace>(known.options());
    for (const State& state : even) space->insert(state);
    even_ = space;
    if (options.even) states = std::move(even);
  }
  if (options.neighbours > 0) return;
  all_ = processes_of(averaged_boxes(states, options.box), With::doubt);
}

ForceField::Processes ForceField::processes_of(const MeasuredRows& rows, With with) const {
  Processes made;
  FieldLaw law = options_.law;
  if (options_.local)
    if (const auto own = improved_law(rows, law, {.steps = local_steps, .noise = options_.noise}))
      law = own->law;
  made.own = std::make_shared<const GaussianProcess>(rows, law);
  if (options_.doubt.length > 0 && with == With::doubt)
    made.doubt = std::make_shared<const GaussianProcess>(stretched(rows, options_.stretch), options_.doubt);
  if (options_.spline.amplitude > 0) made.spline = std::make_shared<const ThinPlate>(rows, options_.spline);
  return made;
}

// The likeliest law of a smooth field may be much longer than the extent of the rows: the field is then a polynomial of
// low degree, and the process is sure of it between the rows, where nothing was measured. So the deviation comes from
// `doubt`. Where the process is unsure, as between two presses far apart, the spline is often nearer; where it knows
// the field, it has nearly all weight. Where the likeliest law is a rough one (Matern's), the field may have a kink
// between the rows as it has one elsewhere: s is then at least the deviation of the spline.
ForceField::Prediction ForceField::predicted(const Vec3& x) const {
  const Processes of = all_.own ? all_ : processes_of(rows_about(x), With::doubt);
  const Blend found = blend(of, x);
  const GaussianProcess::Prediction& likeliest = found.likeliest;
  const GaussianProcess::Prediction judged = of.doubt ? of.doubt->at(options_.stretch * x) : likeliest;
  Prediction made{
      .force = found.force, .alone = likeliest.force, .own_deviation = std::sqrt(3.0) * likeliest.deviation};
  double rough = 0;
  if (of.spline && options_.law.smoothness != Smoothness::gaussian)
    rough = std::sqrt(3.0) * found.plain.deviation;
  made.deviation = std::hypot(std::sqrt(3.0) * judged.deviation, (judged.force - made.force).norm());
  made.deviation = std::max(made.deviation, rough);
  return made;
}

ForceField::Blend ForceField::blend(const Processes& of, const Vec3& x) {
  Blend found{.likeliest = of.own->at(x)};
  found.force = found.likeliest.force;
  if (!of.spline) return found;
  found.plain = of.spline->at(x);
  const double ratio =
      found.plain.deviation / std::max(found.likeliest.deviation, std::numeric_limits<double>::min());
  found.force += (found.plain.force - found.likeliest.force) / (1 + std::pow(ratio, 4));
  return found;
}

// The nearest rows. Where they lie on lines or in heaps, 120 of them may all be of one. Then a row counts only if it is
// apart from all nearer ones by a share of its distance from x; else the nearest of these stands for it too, if the
// force changes less between both than its noise.
MeasuredRows ForceField::rows_about(const Vec3& x) const {
  std::vector<StateId> ids;
  const std::size_t count = options_.neighbours;
  known_->nearest(x, count, ids);
  MeasuredRows rows;
  for (const StateId id : ids) rows.add((*known_)[id].at, (*known_)[id].force);
  if ((rows.at.back() - x).norm() < most_even * median_spacing(rows.at)) return rows;
  known_->nearest(x, most_tried * count, ids);
  rows = {};
  const double alike = options_.stiffest > 0 ? surely_off * options_.law.noise / options_.stiffest : 0;
  for (const StateId id : ids) {
    const State& row = (*known_)[id];
    const double apart = rows_apart * (row.at - x).norm();
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (const double d = (rows.at[i] - row.at).squaredNorm(); d < least) least = d, nearest = i;
    if (least >= apart * apart) {
      if (rows.size() == count) break;
      rows.add(row.at, row.force);
    } else if (std::sqrt(least) <= alike) {
      const double weight = rows.weight[nearest] += 1;
      rows.at[nearest] += (row.at - rows.at[nearest]) / weight;
      rows.force[nearest] += (row.force - rows.force[nearest]) / weight;
    }
  }
  return rows;
}

// Let M be the covariance of the positions within 4 d of x (d: distance of the nearest row; at least 12 rows) and c
// their mean. An eigenvector u of M is unknown at x if |u.(x - c)| exceeds four times the deviation of the rows along
// u. A direction is thin if the rows deviate in it by less than a fifth of their largest deviation. There c and the
// deviation are those of a parabola along the rows. The foot is x without its components along unknown directions,
// about c.
ForceField::Foot ForceField::foot_of(const Vec3& x) const {
  const StateSpace& even = even_ ? *even_ : *known_;
  std::vector<StateId> ids;
  even.nearest(x, 1, ids);
  const double nearest = (even[ids.front()].at - x).norm();
  even.within(x, 4 * nearest, ids);
  if (ids.size() < least_around) even.nearest(x, least_around, ids);
  const std::size_t stride = ids.size() / most_around + 1;
  Vec3 middle = Vec3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < ids.size(); i += stride) middle += even[ids[i]].at - x, ++count;
  middle /= count;
  Mat3 spread = Mat3::Zero();
  for (std::size_t i = 0; i < ids.size(); i += stride) {
    const Vec3 off = even[ids[i]].at - x - middle;
    spread += off * off.transpose() / count;
  }
  const Modes3 axes = axes_of(spread);
  std::vector<Vec3> near;  // from x, along the axes: the rows extend least along the first
  for (std::size_t i = 0; i < ids.size(); i += stride)
    near.push_back(axes.vectors.transpose() * (even[ids[i]].at - x));
  const double widest = std::sqrt(std::max(0.0, axes.values[2]));
  Vec3 across = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = axes.vectors.col(k);
    const double own = std::sqrt(std::max(0.0, axes.values[k]));
    const Lie lie = own < thin * widest ? lie_of(near, k) : Lie{.off = u.dot(middle), .deviation = own};
    const double off = std::abs(lie.off) - surely_off * lie.doubt;
    if (known_share * off > lie.deviation) across -= lie.off * u;
  }
  if (!(across.norm() > 0)) return {.at = x};
  const Vec3 foot = x - across;
  const std::optional<Vec3> told = row_across(x, foot);  // the nearest row that tells of the direction across
  if (!told) return {.at = foot, .across = across.norm()};
  return {.at = x, .across = across.norm(), .between = 0.5 * (x + *told)};
}

// Rows within l may lie beyond x, or on the far side of the foot, within 60 degrees of the direction across and at
// least E away: those of the next line of a raster, or of another turn of a curve. Then x itself is used in place of
// the foot, and its error is at least the lesser of S E and the deviation halfway to the nearest of these rows.
std::optional<Vec3> ForceField::row_across(const Vec3& x, const Vec3& foot) const {
  const double across = (x - foot).norm();
  const Vec3 u = (x - foot) / across;
  std::optional<Vec3> found;
  double nearest = std::max(options_.law.length, most_across * across);
  std::uint32_t last = 0;  // of equally near rows the last is found
  const auto look = [&](const Vec3& from, const Vec3& towards) {
    known_->points().for_each_within(from, nearest * (1 + 1e-12),
                                     [&](std::uint32_t row, const Vec3& offset, double) {
                                       const double away = offset.norm();
                                       if (away > nearest || (found && away == nearest && row < last)) return;
                                       if (!(away >= across && offset.dot(towards) >= cone * away)) return;
                                       found = (*known_)[StateId{row}].at;
                                       nearest = away;
                                       last = row;
                                     });
  };
  look(x, u);
  look(foot, -u);
  return found;
}

ForceField::Prediction ForceField::at(const Vec3& x) const {
  const Foot foot = foot_of(x);
  Prediction made = predicted(foot.at);
  made.foot = foot.at;
  made.least_error = options_.stiffest * foot.across;
  if (!options_.stated) made.least_error = std::min(made.least_error, bound());
  if (foot.between) made.least_error = std::min(made.least_error, predicted(*foot.between).deviation);
  made.force = bounded(made.force);
  made.alone = bounded(made.alone);
  return made;
}

ForceField::Linear ForceField::linear(const Vec3& x, double step) const {
  const Processes of = all_.own ? all_ : processes_of(rows_about(foot_of(x).at), With::force_alone);
  const auto force = [&](const Vec3& at) { return bounded(blend(of, foot_of(at).at).force); };
  Linear made{.force = force(x)};
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 off = step * Vec3::Unit(axis);
    made.stiffness.col(axis) = (force(x - off) - force(x + off)) / (2 * step);
  }
  return made;
}

Vec3 ForceField::bounded(const Vec3& force) const {
  const double size = force.norm();
  return size > bound() ? Vec3(force * (bound() / size)) : force;
}

double ForceField::bound() const {
  return most_overshoot * most_;
}

}  // namespace forefeel
