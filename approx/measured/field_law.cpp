#include "approx/measured/field_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "approx/measured/position_groups.hpp"
#include "geometry/common/dense.hpp"
#include "geometry/states/heaps.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_rows = 1300;                     // of the process of all rows
constexpr std::size_t field_neighbours = 120;               // of a place, where the rows are not averaged
constexpr std::size_t law_clusters = 64, cluster_rows = 4;  // rows that the law is first fitted to
constexpr std::size_t more_clusters = 110;                  // and those that it is improved with
constexpr std::size_t most_clusters = 300;                  // and those that the kind of law is chosen by
constexpr std::size_t law_boxes = 500;
constexpr int first_polishing = 5, polishing = 20, last_polishing = 10;  // steps
constexpr std::size_t enough_groups = 20;  // that tell a better law than the likeliest
constexpr double surely_better = 2.1;      // standard errors of the mean difference of scores
constexpr double most_sag = 0.3;           // of a box, in deviations of its mean
constexpr double longest_doubt = 1.8;      // length, in extents of the rows (root mean square)
constexpr double least_apart = 0.1;        // of boxes for a secant, in lengths and radii
constexpr double surely = 2.8;  // 95 % of |e| lie within 2.8 deviations of a component (chi, 3 degrees)
constexpr std::size_t fewest_of_places = 4;  // rows, in those of a place, for a law of each place
constexpr double fewest_deviations = 0.05;   // of a direction that tells, in the largest deviation
constexpr int stretch_steps = 8;             // of the search for l, a and sigma at one A
constexpr double a_gain = 0.5;               // of the log likelihood, by a step
constexpr double sure_gain = 6;              // by all: two lengths more are worth 2 by chance (Akaike 1974)

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

// Whether the field bends less within boxes of `size` rows than the noise of their means. even: those of the rows, in
// order, at which that is asked; a heap would hide that its boxes are small and all others large.
bool flat_within(std::span<const State> states, std::span<const State> even, std::size_t size,
                 const FieldLaw& law) {
  if (size == 1) return true;
  const MeasuredRows boxes = averaged_boxes(states, size);
  const PositionGroups groups = compact_groups(positions_of(states), size, true);
  double squared = 0;
  for (std::size_t i = 0, k = 0; i < states.size() && k < even.size(); ++i) {
    if (states[i].at != even[k].at) continue;
    squared += (states[i].at - boxes.at[groups.of[i]]).squaredNorm() / double(even.size());
    ++k;
  }
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

// Lengths that differ by direction. A body pressed from above changes its force quicker with depth than along it, and a
// law of one length, which rows along many lines determine, is then sure of what lies between two depths. With A
// symmetric, of determinant 1, in the principal directions of the rows:
//   cov(g_c(x), g_c(x')) = a^2 r(|A (x - x')| / l)
// A is found by steps of a factor in one direction at a time, as long as they raise the likelihood. Returns A; the
// identity if it is not surely likelier. A direction in which the rows deviate by less than a twentieth of their
// largest deviation tells nothing and keeps its length. Some thirty searches of improved_law().
Mat3 likely_stretch(const MeasuredRows& rows, const FieldLaw& law, std::optional<double> noise) {
  const auto count = static_cast<double>(rows.size());
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : rows.at) middle += x / count;
  Mat3 spread = Mat3::Zero();
  for (const Vec3& x : rows.at) spread += (x - middle) * (x - middle).transpose() / count;
  const Modes3 axes = axes_of(spread);
  const Mat3& directions = axes.vectors;
  const auto stretch_of = [&](const Vec3& by) -> Mat3 {
    return directions * (by / std::cbrt(by.prod())).asDiagonal() * directions.transpose();
  };
  const auto unlikely = [&](const Vec3& by) {
    const auto found =
        improved_law(stretched(rows, stretch_of(by)), law, {.steps = stretch_steps, .noise = noise});
    return found ? found->minus_log_likelihood : std::numeric_limits<double>::infinity();
  };
  Vec3 best = Vec3::Ones();
  double least = unlikely(best);
  const double alike = least;
  for (const double step : {2.0, 2.0, 2.0, 1.4}) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!(axes.values[axis] > fewest_deviations * fewest_deviations * axes.values[2])) continue;
      for (const double factor : {step, 1 / step}) {
        Vec3 tried = best;
        tried[axis] *= factor;
        if (const double value = unlikely(tried); value < least - a_gain) {
          least = value;
          best = tried;
          break;
        }
      }
    }
  }
  return alike - least > sure_gain ? stretch_of(best) : Mat3::Identity();
}

double radius_of(const MeasuredRows& rows) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : rows.at) middle += x / double(rows.size());
  double most = 0;
  for (const Vec3& x : rows.at) most = std::max(most, (x - middle).norm());
  return most;
}

}  // namespace

MeasuredRows stretched(MeasuredRows rows, const Mat3& by) {
  for (Vec3& x : rows.at) x = by * x;
  return rows;
}

MeasuredRows averaged_boxes(std::span<const State> states, std::size_t size) {
  MeasuredRows rows;
  const PositionGroups groups = compact_groups(positions_of(states), size, true);
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
  const std::vector<State> even = thinned_heaps(states);
  const MeasuredRows some = rows_for_law(even, law_clusters), more = rows_for_law(even, more_clusters),
                     most = rows_for_law(even, most_clusters);
  const std::size_t size = box_size(even.size(), law_boxes);
  const MeasuredRows boxes = averaged_boxes(even, size);
  std::optional<LikelyLaw> best, rough, doubt;
  Mat3 stretch = Mat3::Identity();
  const auto fit = [&](std::optional<double> known) {
    const ChosenLaw chosen = chosen_law(some, more, most, known);
    best = chosen.best;
    rough = chosen.rough;
    if (best && size > 1 && flat_within(even, even, size, best->law))
      best = improved_law(boxes, best->law, {.steps = polishing, .noise = known});
    if (!best) return;
    stretch = likely_stretch(some, best->law, known);
    doubt = improved_law(stretched(more, stretch), best->law,
                         {.steps = polishing, .noise = known, .longest = longest_doubt});
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
      .doubt = doubt ? doubt->law : FieldLaw{},
      .stretch = stretch,
      .stiffest = std::max(largest_secant(boxes, best->law.noise, apart), largest / radius_of(boxes)),
      .box = box_size(states.size(), most_rows)};
  if (rough) found.rough = rough->law;
  found.noise = noise.force;
  if (found.stretch.isIdentity() && best->law.length <= found.doubt.length) found.doubt = {};
  found.spline = likely_spline(more, noise.force).value_or(SplineLaw{});
  if (flat_within(states, even, found.box, best->law)) return found;
  found.even = even.size() < states.size();
  found.box = box_size(even.size(), most_rows);
  if (!flat_within(even, even, found.box, best->law)) found.neighbours = field_neighbours;
  return found;
}

std::optional<FieldOptions> local_field(const FieldOptions& field, std::size_t rows) {
  if (!(field.rough.amplitude > 0) || rows < fewest_of_places * field_neighbours) return {};
  FieldOptions local = field;
  local.law = field.rough;
  local.doubt = {};
  local.spline = {};
  local.neighbours = field_neighbours;
  local.local = true;
  return local;
}

}  // namespace forefeel
