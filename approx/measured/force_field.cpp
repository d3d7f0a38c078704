#include "approx/measured/force_field.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "approx/measured/position_groups.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_rows = 1300;                     // of the process of all rows
constexpr std::size_t field_neighbours = 120;               // of a place, where the rows are not averaged
constexpr std::size_t law_clusters = 64, cluster_rows = 4;  // rows that the law is first fitted to
constexpr std::size_t more_clusters = 110;                  // and those that it is improved with
constexpr std::size_t most_clusters = 300;                  // and those that the kind of law is chosen by
constexpr std::size_t law_boxes = 500;
constexpr int first_polishing = 5, polishing = 20, last_polishing = 10;  // steps
constexpr int local_steps = 15;
constexpr std::size_t enough_groups = 20;  // that tell a better law than the likeliest
constexpr double surely_better = 2.1;      // standard errors of the mean difference of scores
constexpr double most_sag = 0.3;                    // of a box, in deviations of its mean
constexpr double longest_doubt = 1.8;               // length, in extents of the rows (root mean square)
constexpr double least_apart = 0.1;                 // of boxes for a secant, in lengths and radii
constexpr std::size_t most_around = 2000;           // rows that show which directions are known
constexpr std::size_t least_around = 12;
constexpr double least_across =
    0.05;  // in distances of the nearest row: less is the sag of a curve between rows
constexpr double known_share = 0.25;  // a direction is known up to the deviation of the rows divided by this
constexpr double thin = 0.2;  // deviation of a thin direction, in the largest of the rows about a place
constexpr double thin_share = 0.67;  // its share of the distance across, below which the error grows
constexpr double surely_off = 2;     // standard errors of where rows lie, within which a place is among them
constexpr double surely = 2.8;       // 95 % of |e| lie within 2.8 deviations of a component (chi, 3 degrees)
constexpr double cone = 0.5;  // cosine of the angle to the direction across, within which rows tell of it
constexpr double most_across =
    10;  // distances across, within which rows beyond tell of the direction at any l
constexpr double spline_share = 0.7;  // of the spline's deviation, in its weight
constexpr double most_overshoot = 2;  // no force is larger than this many times the largest known one

std::vector<Vec3> positions_of(std::span<const State> states) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  return at;
}

// Clusters of neighbouring states, evenly drawn: near ones show the noise, far ones the length of the field.
MeasuredRows rows_for_law(std::span<const State> states, std::size_t clusters) {
  MeasuredRows rows;
  const std::vector<Vec3> at = positions_of(states);
  const PositionGroups groups = compact_groups(at, cluster_rows);
  const std::size_t stride = (groups.count + clusters - 1) / clusters;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (groups.of[i] % stride == 0) rows.add(states[i].at, states[i].force);
  return rows;
}

// Rows of a box, so that there are at most so many boxes: a power of 2.
std::size_t box_size(std::size_t rows, std::size_t most_boxes) {
  std::size_t size = 1;
  while (rows > size * most_boxes) size *= 2;
  return size;
}

// Whether the field bends less within boxes of `size` rows than the noise of their means.
bool flat_within(std::span<const State> states, std::size_t size, const FieldLaw& law) {
  if (size == 1) return true;
  const MeasuredRows boxes = averaged_boxes(states, size);
  const PositionGroups groups = compact_groups(positions_of(states), size);
  double squared = 0;
  for (std::size_t i = 0; i < states.size(); ++i)
    squared += (states[i].at - boxes.at[groups.of[i]]).squaredNorm() / double(states.size());
  const double sag = 0.5 * law.amplitude * squared / (law.length * law.length);
  return sag <= most_sag * law.noise / std::sqrt(double(size));
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

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v / double(values.size());
  return sum;
}

// Whether the mean of a is less than that of b, as far as their differences show.
bool surely_less(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0, squares = 0;
  const auto n = double(a.size());
  for (std::size_t g = 0; g < a.size(); ++g) sum += b[g] - a[g], squares += std::pow(b[g] - a[g], 2);
  const double mean = sum / n;
  return mean > surely_better * std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1));
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
  const Eigen::CompleteOrthogonalDecomposition<Mat3> factor(normal);
  const Vec3 parabola = factor.solve(right), here = powers(std::clamp(0.0, first, last));
  double squared = 0;
  for (const Vec3& r : near) squared += std::pow(r[axis] - parabola.dot(powers(r[2])), 2);
  Lie lie{.off = parabola.dot(here),
          .deviation = std::sqrt(squared / std::max(1.0, double(near.size()) - 3))};
  lie.doubt = lie.deviation * std::sqrt(std::max(0.0, here.dot(factor.solve(here))));
  return lie;
}

// Groups that are left out to compare laws: the largest natural ones of which there are enough, or boxes of four.
PositionGroups groups_of(const MeasuredRows& rows) {
  std::optional<PositionGroups> largest;
  for (PositionGroups& level : natural_groups(rows.at))
    if (level.count >= enough_groups && (!largest || level.count < largest->count))
      largest = std::move(level);
  return largest ? *std::move(largest) : compact_groups(rows.at, cluster_rows);
}

struct ChosenLaw {
  std::optional<LikelyLaw> best, rough;
};

// The kind of law by the likelihood of the most rows. Another, if it surely predicts single rows better; and another
// than that, if it surely predicts groups of them better, which are as hard as what is asked.
ChosenLaw chosen_law(const MeasuredRows& some, const MeasuredRows& more, const MeasuredRows& most,
                     std::optional<double> noise) {
  constexpr std::array kinds{Smoothness::gaussian, Smoothness::matern52, Smoothness::matern32};
  std::array<std::optional<LikelyLaw>, kinds.size()> laws;
  std::array<std::vector<std::vector<double>>, kinds.size()> scores;
  const bool all = most.size() > more.size();
  std::vector<Grouping> groupings;
  if (all) groupings = {compact_groups(most.at, 1).of, groups_of(most).of};
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    laws[k] = likely_law(some, kinds[k], noise);
    if (laws[k]) laws[k] = improved_law(more, laws[k]->law, {.steps = first_polishing, .noise = noise});
    if (laws[k] && all) laws[k] = improved_law(most, laws[k]->law, {.steps = last_polishing, .noise = noise});
    if (laws[k] && all) scores[k] = left_out_scores(most, laws[k]->law, groupings);
  }
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (laws[k] && (!best || laws[k]->minus_log_likelihood < laws[*best]->minus_log_likelihood)) best = k;
  if (!best) return {};
  const std::optional<LikelyLaw>& rough = laws.back();
  if (!all) return {improved_law(more, laws[*best]->law, {.steps = polishing, .noise = noise}), rough};
  for (std::size_t g = 0; g < groupings.size(); ++g) {
    std::size_t surest = *best;
    for (std::size_t k = 0; k < kinds.size(); ++k)
      if (!scores[k].empty() && !scores[surest].empty() && mean_of(scores[k][g]) < mean_of(scores[surest][g]))
        surest = k;
    if (surest != *best && surely_less(scores[surest][g], scores[*best][g])) best = surest;
  }
  return {laws[*best], rough};
}

double radius_of(const MeasuredRows& rows) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : rows.at) middle += x / double(rows.size());
  double most = 0;
  for (const Vec3& x : rows.at) most = std::max(most, (x - middle).norm());
  return most;
}

}  // namespace

MeasuredRows averaged_boxes(std::span<const State> states, std::size_t size) {
  MeasuredRows rows;
  const PositionGroups groups = compact_groups(positions_of(states), size);
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
  const MeasuredRows some = rows_for_law(states, law_clusters), more = rows_for_law(states, more_clusters),
                     most = rows_for_law(states, most_clusters);
  const std::size_t size = box_size(states.size(), law_boxes);
  const MeasuredRows boxes = averaged_boxes(states, size);
  std::optional<LikelyLaw> best, rough, doubt;
  const auto fit = [&](std::optional<double> known) {
    const ChosenLaw chosen = chosen_law(some, more, most, known);
    best = chosen.best;
    rough = chosen.rough;
    if (best && size > 1 && flat_within(states, size, best->law))
      best = improved_law(boxes, best->law, {.steps = polishing, .noise = known});
    if (best)
      doubt = improved_law(more, best->law, {.steps = polishing, .noise = known, .longest = longest_doubt});
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
  double largest = 0;
  for (const Vec3& f : boxes.force) largest = std::max(largest, f.norm());
  const double apart = std::min(least_apart * best->law.length, least_apart * radius_of(boxes));
  FieldOptions found{
      .law = best->law,
      .doubt = doubt ? doubt->law : best->law,
      .stiffest = std::max(largest_secant(boxes, best->law.noise, apart), largest / radius_of(boxes)),
      .box = box_size(states.size(), most_rows)};
  if (rough) found.rough = rough->law;
  found.noise = noise.force;
  if (best->law.length <= found.doubt.length) found.doubt = best->law;
  found.spline = likely_spline(more, noise.force).value_or(SplineLaw{});
  if (!flat_within(states, found.box, best->law)) found.neighbours = field_neighbours;
  return found;
}

std::optional<FieldOptions> local_field(const FieldOptions& field, std::size_t rows) {
  if (!(field.rough.amplitude > 0) || rows < 4 * field_neighbours) return {};
  FieldOptions local = field;
  local.law = field.rough;
  local.doubt = {};
  local.spline = {};
  local.neighbours = field_neighbours;
  local.local = true;
  return local;
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
  if (options.neighbours > 0) return;
  all_ = processes_of(averaged_boxes(states, options.box));
}

ForceField::Processes ForceField::processes_of(const MeasuredRows& rows) const {
  Processes made;
  FieldLaw law = options_.law;
  if (options_.local)
    if (const auto own = improved_law(rows, law, {.steps = local_steps, .noise = options_.noise})) law = own->law;
  made.own = std::make_shared<const GaussianProcess>(rows, law);
  if (doubted()) made.doubt = std::make_shared<const GaussianProcess>(rows, options_.doubt);
  if (options_.spline.amplitude > 0) made.spline = std::make_shared<const ThinPlate>(rows, options_.spline);
  return made;
}

bool ForceField::doubted() const {
  return options_.doubt.length > 0 && options_.doubt.length < options_.law.length;
}

ForceField::Prediction ForceField::predicted(const Vec3& x) const {
  Processes of = all_;
  if (!of.own) {
    std::vector<StateId> ids;
    known_->nearest(x, options_.neighbours, ids);
    MeasuredRows rows;
    for (const StateId id : ids) rows.add((*known_)[id].at, (*known_)[id].force);
    of = processes_of(rows);
  }
  const GaussianProcess::Prediction likeliest = of.own->at(x),
                                    judged = of.doubt ? of.doubt->at(x) : likeliest;
  Prediction made{.force = likeliest.force,
                  .alone = likeliest.force,
                  .own_deviation = std::sqrt(3.0) * likeliest.deviation};
  double rough = 0;
  if (of.spline) {
    const GaussianProcess::Prediction plain = of.spline->at(x);
    const double ratio =
        spline_share * plain.deviation / std::max(likeliest.deviation, std::numeric_limits<double>::min());
    made.force += (plain.force - likeliest.force) / (1 + std::pow(ratio, 4));
    if (options_.law.smoothness != Smoothness::gaussian) rough = std::sqrt(3.0) * plain.deviation;
  }
  made.deviation = std::hypot(std::sqrt(3.0) * judged.deviation, (judged.force - made.force).norm());
  made.deviation = std::max(made.deviation, rough);
  return made;
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
  std::vector<Vec3> near;  // from x, along the axes: the rows extend least along the first
  for (std::size_t i = 0; i < ids.size(); i += stride)
    near.push_back(axes.eigenvectors().transpose() * ((*known_)[ids[i]].at - x));
  const double widest = std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
  Vec3 across = Vec3::Zero(), doubtful = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = axes.eigenvectors().col(k);
    const double own = std::sqrt(std::max(0.0, axes.eigenvalues()[k]));
    const Lie lie = own < thin * widest ? lie_of(near, k) : Lie{.off = u.dot(middle), .deviation = own};
    const double off = std::abs(lie.off) - surely_off * lie.doubt;
    if (known_share * off > lie.deviation)
      across -= lie.off * u;
    else if (lie.deviation < thin * widest && thin_share * off > lie.deviation)
      doubtful -= lie.off * u;
  }
  const double least = least_across * nearest;
  const Vec3 foot = x - across;
  std::optional<Vec3> told;  // the nearest row that tells of the direction across
  if (across.norm() > least) {
    told = row_across(x, foot);
    if (!told) return {.at = foot, .across = (across + doubtful).norm()};
  }
  if (doubtful.norm() > least) {
    const Vec3 thinnest = x - doubtful;
    told = row_across(x, thinnest);
    if (!told) return {.at = x, .across = doubtful.norm()};
    return {.at = x, .across = doubtful.norm(), .between = 0.5 * (x + *told)};
  }
  if (!told) return {.at = x};
  return {.at = x, .across = across.norm(), .between = 0.5 * (x + *told)};
}

std::optional<Vec3> ForceField::row_across(const Vec3& x, const Vec3& foot) const {
  const double across = (x - foot).norm();
  const Vec3 u = (x - foot) / across;
  std::optional<Vec3> found;
  double nearest = std::max(options_.law.length, most_across * across);
  const auto tells = [&](const Vec3& from, const Vec3& towards) {
    const double away = from.norm();
    return away >= across && away <= nearest && from.dot(towards) >= cone * away;
  };
  for (const Vec3& at : rows_)
    for (const bool beyond : {true, false})
      if (beyond ? tells(at - x, u) : tells(at - foot, -u)) {
        found = at;
        nearest = (at - (beyond ? x : foot)).norm();
      }
  return found;
}

ForceField::Prediction ForceField::at(const Vec3& x) const {
  const Foot foot = foot_of(x);
  Prediction made = predicted(foot.at);
  made.foot = foot.at;
  made.least_error = std::min(options_.stiffest * foot.across, bound());
  if (foot.between) made.least_error = std::min(made.least_error, predicted(*foot.between).deviation);
  made.force = bounded(made.force);
  made.alone = bounded(made.alone);
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
