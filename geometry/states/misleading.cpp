#include "geometry/states/misleading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "geometry/states/force_trend.hpp"
#include "geometry/states/hysteresis.hpp"
#include "geometry/states/state_summary.hpp"
#include "geometry/states/stiffness_agreement.hpp"

namespace forefeel {
namespace {

constexpr double most_spacings = 20;           // between neighbours, in metres
constexpr double widest_reach = 3;             // of states that a hand touches [m]
constexpr std::size_t beside = 12;             // states that tell of a force
constexpr double one_place = 0.2;              // of the distance: less between two of them is one place
constexpr std::size_t most_near = 1000;        // rows among which these are sought
constexpr double far_off = 8;                  // from them, in their largest difference
constexpr std::size_t most_lone_share = 100;   // one of so many
constexpr std::size_t most_compared = 20'000;  // states

// Longest side of the box of all but one.
double side_without(std::span<const State> states, const State* left_out) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const State& s : states)
    if (&s != left_out) low = low.cwiseMin(s.at), high = high.cwiseMax(s.at);
  return (high - low).maxCoeff();
}

std::string one_far_row(std::span<const State> states) {
  const std::optional<std::size_t> row = far_row(states);
  if (!row) return {};
  const Vec3& x = states[*row].at;
  return fmt::format(
      "row {} at {:.4g},{:.4g},{:.4g} m is far from all others, which span {:.3g} m; if the tracker was "
      "lost there, leave it out",
      *row + 1, x.x(), x.y(), x.z(), side_without(states, &states[*row]));
}

// The clock of a recorder where a place was expected. A lattice, a raster and a stroke repeat x, run back or have y and
// z follow it.
std::string time_for_x(std::span<const State> states) {
  constexpr std::size_t fewest_rows = 20;
  constexpr double equal = 1e-3;        // of a step: the digits of the file
  constexpr double back_and_forth = 4;  // of the travel along an axis, in the width along it
  if (states.size() < fewest_rows || !(states.front().at.x() >= 0)) return {};
  const double step = (states.back().at.x() - states.front().at.x()) / double(states.size() - 1);
  if (!(step > 0)) return {};
  Vec3 travel = Vec3::Zero(), low = states.front().at, high = low;
  for (std::size_t i = 1; i < states.size(); ++i) {
    const Vec3 change = states[i].at - states[i - 1].at;
    if (!(std::abs(change.x() - step) < equal * step)) return {};
    travel += change.cwiseAbs();
    low = low.cwiseMin(states[i].at), high = high.cwiseMax(states[i].at);
  }
  const Vec3 width = high - low;
  for (const int axis : {1, 2})
    if (width[axis] > step && travel[axis] > back_and_forth * width[axis])
      return fmt::format(
          "x rises by {:.4g} from row to row, as a clock does, while {} goes back and forth; if it is the "
          "time, import --columns names the columns of the position",
          step, "xyz"[axis]);
  return {};
}

std::string unlikely_unit(std::span<const State> states, double spacing) {
  std::optional<Box> box;
  for (const State& state : states) {
    if (!box) box = Box{state.at, state.at};
    box = Box{box->low.cwiseMin(state.at), box->high.cwiseMax(state.at)};
  }
  const double side = box ? box->size().maxCoeff() : 0, apart = typical_distance(states);
  if (!std::isfinite(apart) || (!(apart > most_spacings * spacing) && !(side > widest_reach))) return {};
  if (side > widest_reach && far_row(states)) return {};  // which is said
  const std::string of = spacing > 0 ? fmt::format(", with a spacing of {:g} mm", 1e3 * spacing) : "";
  Vec3 sides = box->size();
  Eigen::Index longest = 0;
  sides.maxCoeff(&longest);
  sides[longest] = 0;
  if (side > widest_reach && sides.maxCoeff() < 0.02 * side)
    return fmt::format(
        "the states span {:.3g} m along {} and at most {:.3g} m along the others; expected metres in each "
        "column",
        side, "xyz"[longest], sides.maxCoeff());
  return fmt::format(
      "the states span {:.3g} m and are {:.3g} m apart{}; expected metres, or --unit cm, mm or um of import",
      side, apart, of);
}

using Near = std::pair<double, const State*>;  // squared distance

// Rows sorted into cubes of a few rows each.
class RowCubes {
 public:
  explicit RowCubes(std::span<const State* const> rows) {
    Vec3 high = rows.front()->at;
    low_ = high;
    for (const State* row : rows) low_ = low_.cwiseMin(row->at), high = high.cwiseMax(row->at);
    const double most = static_cast<double>(rows.size()) / in_cube;
    const Vec3 size = high - low_;
    side_ = std::max(size.maxCoeff() / 64, std::cbrt(size.prod() / most));
    for (int a = 0; a < 3; ++a)
      count_[static_cast<std::size_t>(a)] = side_ > 0 ? static_cast<int>(size[a] / side_) + 1 : 1;
    first_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1] * count_[2]) + 1,
                  0);
    for (const State* row : rows) ++first_[index(cube_of(row->at)) + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    sorted_.resize(rows.size());
    std::vector<std::size_t> next = first_;
    for (const State* row : rows) sorted_[next[index(cube_of(row->at))]++] = row;
  }
  // The n rows nearest to one, at other places, from near to far; equally near ones in their order.
  std::vector<Near> nearest(const State& one, std::size_t n) const {
    std::vector<Near> heap;
    const auto take = [&](const State* row) {
      const Near found((row->at - one.at).squaredNorm(), row);
      if (found.first == 0 || (heap.size() == n && !(found < heap.front()))) return;
      if (heap.size() == n) {
        std::ranges::pop_heap(heap);
        heap.pop_back();
      }
      heap.push_back(found);
      std::ranges::push_heap(heap);
    };
    const Cube middle = cube_of(one.at);
    const int rings = std::max({count_[0], count_[1], count_[2]});
    for (int ring = 0; ring < rings; ++ring) {
      const double within = (ring - 1) * side_;  // of rows in this ring, at least
      if (heap.size() == n && ring > 0 && within * within > heap.front().first) break;
      for_each_in_ring(middle, ring, take);
    }
    std::ranges::sort_heap(heap);
    return heap;
  }

 private:
  using Cube = std::array<int, 3>;
  static constexpr double in_cube = 6;  // rows

  Cube cube_of(const Vec3& x) const {
    Cube cube{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double at = side_ > 0 ? (x[static_cast<int>(a)] - low_[static_cast<int>(a)]) / side_ : 0;
      cube[a] = std::min(static_cast<int>(at), count_[a] - 1);
    }
    return cube;
  }
  std::size_t index(const Cube& c) const {
    return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]);
  }
  // The cubes at this distance from the middle one, by their largest difference.
  template <class Take>
  void for_each_in_ring(const Cube& middle, int ring, Take&& take) const {
    Cube low{}, high{}, c{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(0, middle[a] - ring);
      high[a] = std::min(count_[a] - 1, middle[a] + ring);
    }
    for (c[2] = low[2]; c[2] <= high[2]; ++c[2])
      for (c[1] = low[1]; c[1] <= high[1]; ++c[1]) {
        const bool face = std::max(std::abs(c[2] - middle[2]), std::abs(c[1] - middle[1])) == ring;
        for (c[0] = low[0]; c[0] <= high[0]; ++c[0]) {
          if (!face && std::abs(c[0] - middle[0]) != ring) {
            c[0] = std::max(c[0], middle[0] + ring - 1);  // to the other end of the row
            continue;
          }
          for (std::size_t i = first_[index(c)]; i < first_[index(c) + 1]; ++i) take(sorted_[i]);
        }
      }
  }

  Vec3 low_;
  double side_ = 0;  // [m]
  Cube count_{};
  std::vector<std::size_t> first_;  // of sorted_, by cube
  std::vector<const State*> sorted_;
};

// The first row of each place beside that of one, by distance, sought among the nearest `most_near` rows: many rows
// about one place, a dwell, are one neighbour. Empty: there are fewer than `beside` places.
std::vector<const State*> places_beside(const RowCubes& rows, const State& one) {
  std::vector<const State*> places;
  for (std::size_t n = 4 * beside;; n = std::min(4 * n, most_near)) {
    const std::vector<Near> near = rows.nearest(one, n);
    places.clear();
    for (const auto& [squared, row] : near) {
      const auto same = [&, squared = squared, row = row](const State* place) {
        return (place->at - row->at).squaredNorm() < one_place * one_place * squared;
      };
      if (std::ranges::none_of(places, same)) places.push_back(row);
      if (places.size() == beside) return places;
    }
    if (near.size() < n || n == most_near) return {};
  }
}

// How far the force of a row is from the nearest of those about it, if that is far beyond their differences; else 0.
double alone_by(const RowCubes& rows, const State& one) {
  const std::vector<const State*> near = places_beside(rows, one);
  if (near.empty()) return 0;
  double range = 0, off = (near.front()->force - one.force).norm();
  for (std::size_t i = 0; i < near.size(); ++i) {
    off = std::min(off, (near[i]->force - one.force).norm());
    for (std::size_t j = 0; j < i; ++j) range = std::max(range, (near[i]->force - near[j]->force).norm());
  }
  return range > 0 && off > far_off * range ? off : 0;
}

std::string lone_forces(std::span<const State> states) {
  std::vector<const State*> usable;
  for (const State& s : states)
    if (s.usable() && s.force.allFinite() && !s.has_site()) usable.push_back(&s);
  if (usable.size() > most_compared) return {};
  if (usable.empty()) return {};
  const RowCubes rows(usable);
  std::vector<double> by(usable.size());
#pragma omp parallel for schedule(dynamic, 64)
  for (std::size_t i = 0; i < usable.size(); ++i) by[i] = alone_by(rows, *usable[i]);
  const auto count = static_cast<std::size_t>(std::ranges::count_if(by, [](double off) { return off > 0; }));
  if (count == 0 || count * most_lone_share > usable.size()) return {};
  const auto farthest = static_cast<std::size_t>(std::ranges::max_element(by) - by.begin());
  const Vec3& x = usable[farthest]->at;
  return fmt::format(
      "{} {} far from those of all neighbours, at {:g},{:g},{:g} by {:.2g} N; if the sensor failed there, "
      "remove such "
      "rows: each spoils the force and the bars about it",
      count, count == 1 ? "force is" : "forces are", x.x(), x.y(), x.z(), by[farthest]);
}

}  // namespace

std::optional<std::size_t> far_row(std::span<const State> states) {
  constexpr double least_farther = 5;  // times as wide with it
  if (states.size() < beside) return {};
  // Only a row at an end of an axis can be it.
  const double side = side_without(states, nullptr);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] =
        std::ranges::minmax_element(states, {}, [&](const State& s) { return s.at[axis]; });
    for (const State* row : {&*low, &*high})
      if (const double rest = side_without(states, row); rest < widest_reach && least_farther * rest < side)
        return static_cast<std::size_t>(row - states.data());
  }
  return {};
}

std::vector<std::string> misleading(std::span<const State> states, double spacing) {
  std::vector<std::string> lines = contrary_forces(states);
  lines.insert(lines.begin(), {disagreement_in_words(stiffness_agreement(states)), one_far_row(states),
                               time_for_x(states), unlikely_unit(states, spacing)});
  lines.push_back(lone_forces(states));
  lines.push_back(hysteresis_in_words(states));
  std::erase(lines, "");
  return lines;
}

}  // namespace forefeel
