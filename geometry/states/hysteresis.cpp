#include "geometry/states/hysteresis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/common/counted.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double knot_share = 0.02;  // of the usual distance from the middle
constexpr std::size_t most_knots = 4000;
constexpr double goes_on = 0.5;        // cosine between two steps of a path
constexpr double along = 0.5;          // cosine between motion and force
constexpr double near_share = 0.1;     // of the force: more may change between the two places of a pair
constexpr double least_paired = 0.25;  // of the knots of a course: a path that crosses itself is no loop
constexpr std::size_t fewest_pairs = 6, enough_strokes = 8;
constexpr double surely = 4;          // standard errors
constexpr double steeper = 3;         // times the stiffness along the path
constexpr double least_share = 0.01;  // of the force

struct Knot {
  Vec3 at = Vec3::Zero(), force = Vec3::Zero();
  int course = 0;          // 1: against the force, -1: with it
  double stiffness = 0;    // along the path [N/m]
  std::size_t stroke = 0;  // run of knots of one course
};

// Robust against single rows far off: medians.
double usual_distance(std::span<const State* const> rows) {
  Vec3 middle;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> values;
    for (const State* row : rows) values.push_back(row->at[a]);
    middle[a] = median(std::move(values));
  }
  std::vector<double> away;
  for (const State* row : rows) away.push_back((row->at - middle).norm());
  return median(std::move(away));
}

std::vector<Knot> knots_of(std::span<const State* const> rows, double reach) {
  std::vector<Knot> knots;
  Vec3 first = Vec3::Zero();
  double count = 0;
  for (const State* row : rows) {
    if (knots.empty() || (row->at - first).norm() > reach) {
      knots.emplace_back();
      first = row->at;
      count = 0;
    }
    ++count;
    Knot& knot = knots.back();
    knot.at += (row->at - knot.at) / count;
    knot.force += (row->force - knot.force) / count;
  }
  return knots;
}

void find_courses(std::vector<Knot>& knots) {
  std::size_t strokes = 0;
  const Knot* last = nullptr;  // of a course
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    Knot& knot = knots[k];
    const Vec3 before = knot.at - knots[k - 1].at, after = knots[k + 1].at - knot.at, move = before + after;
    if (before.dot(after) < goes_on * before.norm() * after.norm()) continue;
    knot.stiffness = (knots[k + 1].force - knots[k - 1].force).norm() / move.norm();
    const double with = move.dot(knot.force);
    if (std::abs(with) < along * move.norm() * knot.force.norm() || with == 0) continue;
    knot.course = with > 0 ? -1 : 1;
    // Past a halt or a tremor a stroke goes on where it was going.
    const Vec3 way = last ? Vec3(knot.at - last->at) : Vec3::Zero();
    const bool goes_on_there =
        last && last->course == knot.course && way.dot(move) > goes_on * way.norm() * move.norm();
    if (!goes_on_there) ++strokes;
    knot.stroke = strokes;
    last = &knot;
  }
}

struct Pair {
  double difference = 0, force = 0, doubt = 0;  // Delta, |f|, S d [N]
  int course = 0;
  std::size_t stroke = 0;
};

std::vector<Pair> pairs_of(const std::vector<Knot>& knots) {
  std::vector<std::size_t> segments;  // their first knots
  for (std::size_t k = 0; k + 1 < knots.size(); ++k)
    if (knots[k].course != 0 && knots[k].course == knots[k + 1].course) segments.push_back(k);
  std::vector<Pair> pairs;
  for (const Knot& knot : knots) {
    if (knot.course == 0) continue;
    double least = std::numeric_limits<double>::infinity();
    Vec3 force = Vec3::Zero();
    for (const std::size_t k : segments) {
      const Knot &a = knots[k], &b = knots[k + 1];
      if (a.course == knot.course) continue;
      const Vec3 way = b.at - a.at;
      const double t = way.dot(knot.at - a.at) / way.squaredNorm();
      if (t < 0 || t > 1) continue;
      const double d = (a.at + t * way - knot.at).norm();
      if (d < least) least = d, force = a.force + t * (b.force - a.force);
    }
    const double size = knot.force.norm(), doubt = knot.stiffness * least;
    if (!(doubt <= near_share * size)) continue;
    pairs.push_back({.difference = knot.course * (knot.force - force).dot(knot.force) / size,
                     .force = size,
                     .doubt = doubt,
                     .course = knot.course,
                     .stroke = knot.stroke});
  }
  return pairs;
}

// Standard error of the mean difference, from the scatter of successive pairs: it is noise, as a loop changes slowly.
// Both courses are compared with each other's rows, so half of the pairs tell nothing new.
double error_of_noise(const std::vector<Pair>& pairs) {
  double squared = 0, count = 0;
  for (std::size_t k = 1; k < pairs.size(); ++k)
    if (pairs[k].stroke == pairs[k - 1].stroke)
      squared += 0.5 * std::pow(pairs[k].difference - pairs[k - 1].difference, 2), ++count;
  return count > 0 ? std::sqrt(2 * squared / count / static_cast<double>(pairs.size()))
                   : std::numeric_limits<double>::infinity();
}

// From the scatter of whole strokes, whose errors may be alike, also in the two strokes of a loop. Of few it is not
// known: 0.
double error_of_strokes(const std::vector<Pair>& pairs, double mean, std::size_t& strokes) {
  double squared = 0, own = 0;
  strokes = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    own += pairs[k].difference - mean;
    if (k + 1 < pairs.size() && pairs[k + 1].stroke == pairs[k].stroke) continue;
    squared += own * own;
    own = 0;
    ++strokes;
  }
  return strokes >= enough_strokes ? std::sqrt(2 * squared) / static_cast<double>(pairs.size()) : 0;
}

}  // namespace

std::optional<Hysteresis> hysteresis_of(std::span<const State> states) {
  std::vector<const State*> rows;
  for (const State& s : states)
    if (s.usable() && s.force.allFinite() && !s.has_site()) rows.push_back(&s);
  if (rows.size() < fewest_pairs) return {};
  double reach = knot_share * usual_distance(rows);
  std::vector<Knot> knots = knots_of(rows, reach);
  for (; knots.size() > most_knots && reach > 0; reach *= 2) knots = knots_of(rows, 2 * reach);
  if (knots.size() > most_knots) return {};
  find_courses(knots);
  const std::vector<Pair> pairs = pairs_of(knots);
  Hysteresis found;
  double force = 0, doubt = 0;
  std::array<double, 2> sum{}, count{};  // of each course
  for (const Pair& pair : pairs) {
    sum[pair.course > 0] += pair.difference;
    ++count[pair.course > 0];
    force += pair.force / static_cast<double>(pairs.size());
    doubt += pair.doubt / static_cast<double>(pairs.size());
  }
  const auto known =
      static_cast<double>(std::ranges::count_if(knots, [](const Knot& k) { return k.course != 0; }));
  if (pairs.size() < fewest_pairs || std::min(count[0], count[1]) < least_paired / 2 * known) return {};
  const double mean = (sum[0] + sum[1]) / static_cast<double>(pairs.size());
  // Where a path is coarse, what lies between two knots is wrong by as much in both courses, with different signs.
  const double least = std::min(sum[0] / count[0] / mean, sum[1] / count[1] / mean) * std::abs(mean);
  const double error = std::max(error_of_noise(pairs), error_of_strokes(pairs, mean, found.strokes));
  // The places of a pair are apart by chance in each of many loops; in few, perhaps all in one direction.
  const double loops = found.strokes < enough_strokes ? 1 : 0.5 * static_cast<double>(found.strokes);
  if (!(least > 0.5 * std::abs(mean)) ||
      !(std::abs(mean) > std::max({surely * error, steeper * doubt / std::sqrt(loops), least_share * force})))
    return {};
  found.width = std::abs(mean);
  found.share = found.width / force;
  return found;
}

std::string hysteresis_in_words(std::span<const State> rows) {
  const std::optional<Hysteresis> found = hysteresis_of(rows);
  if (!found) return {};
  return fmt::format(
      "hysteresis: loading and unloading rows of one place differ by {:.2g} N, {} of the force (width "
      "of the "
      "loop, mean of {} strokes); forces between both are their mean; for one course, keep its rows alone",
      found->width, in_percent(found->share), found->strokes);
}

}  // namespace forefeel
