#include "scheduling/policy/coverage_need.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "geometry/common/in_best_set.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/policy/candidate_rows.hpp"
#include "scheduling/policy/need_policy.hpp"

namespace forefeel {
namespace {

constexpr double reach = 2;                                 // of a state, in spacings H
constexpr double least_need = 1e-15;                        // a need below this counts as none
constexpr int multiples[CoverageNeed::scales] = {4, 2, 1};  // H / h

double lack(Label label, int scale) {
  switch (label) {
    case Label::blank:
      return 1;
    case Label::gap:
      return 0.25;
    case Label::sparse:
      return scale == 0 ? 0.0 : 0.1;  // none at 4 h, where the finer spacings give more information
    case Label::safe:
      return 0;
  }
  return 0;
}

// out_i += sum_s need_s (1 - |q - x_i|^2 inverse_s)_+ for first <= i < last; xyz: 3 x #candidates, a
// coordinate a row.
FOREFEEL_INLINE void add_worth(std::size_t first, std::size_t last, std::size_t count,
                               const double* __restrict xyz, const double* q, const double* need,
                               const double* inverse, double* __restrict out) {
  const double* __restrict x = xyz;
  const double* __restrict y = xyz + count;
  const double* __restrict z = xyz + 2 * count;
  const double qx = q[0], qy = q[1], qz = q[2];
  const double n0 = need[0], n1 = need[1], n2 = need[2], i0 = inverse[0], i1 = inverse[1], i2 = inverse[2];
  for (std::size_t i = first; i < last; ++i) {
    const double dx = x[i] - qx, dy = y[i] - qy, dz = z[i] - qz;
    const double d2 = dx * dx + dy * dy + dz * dz;
    const double m0 = 1 - d2 * i0, m1 = 1 - d2 * i1, m2 = 1 - d2 * i2;
    out[i] += n0 * (m0 > 0 ? m0 : 0.0) + n1 * (m1 > 0 ? m1 : 0.0) + n2 * (m2 > 0 ? m2 : 0.0);
  }
}

}  // namespace

CoverageNeed::CoverageNeed(NeedOptions options) : options_(options) {}

void CoverageNeed::begin(const StateSpace& space) {
  space_ = &space;
  known_ = 0;
  missed_ = seen_ = {};
  box_.clear();
  const StateSpaceOptions& options = space.options();
  const double h = options.spacing;
  limits_.clear();
  for (const int multiple : multiples)
    limits_.emplace_back(options.coverage, multiple * h, options.merge_distance * h);
  // Cubes of 2 h that fill the box; larger ones where that gives more than 2000.
  const Vec3 size = options.box.size();
  double side = 2 * h;
  const auto cubes = [&] { return (size / side).array().ceil().max(1.0).eval(); };
  while (cubes().prod() > 2000) side *= 1.25;
  const Eigen::Array3d count = cubes();
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k) {
        const Eigen::Array3d share = (Eigen::Array3d(i, j, k) + 0.5) / count;
        box_.push_back({.at = options.box.low + (size.array() * share).matrix()});
      }
  regions_.clear();
  if (!options_.regions) return;
  for (const int multiple : multiples)
    regions_.emplace_back(
        space, multiple * h,
        std::array{static_cast<int>(count[0]), static_cast<int>(count[1]), static_cast<int>(count[2])});
}

// Labels never get worse: places that are safe at a spacing, and those that no new state can change, keep
// their label.
void CoverageNeed::learn(std::span<const float> surprises) {
  for (; known_ < space_->size(); ++known_) {
    const State& state = (*space_)[StateId{static_cast<std::uint32_t>(known_)}];
    if (known_ < surprises.size() && std::isfinite(surprises[known_])) teach(state.at, surprises[known_]);
    for (RegionShares& region : regions_) region.learn(state.at);
    for (Place& place : box_)
      for (std::size_t s = 0; regions_.empty() && s < scales; ++s)
        if (!place.due[s])
          place.due[s] = may_change(place.kept[s], place.at, state.at,
                                    multiples[s] * space_->options().spacing, limits_[s]);
  }
  for (RegionShares& region : regions_) region.update();
  for (Place& place : box_)
    for (std::size_t s = 0; s < scales; ++s)
      if (std::exchange(place.due[s], false)) place.kept[s] = label_at(*space_, place.at, limits_[s]);
}

// Counts the surprise of state `known_` at the coarsest spacing at which its place was blank or a gap before it came:
// where no earlier state was within the sparse distance.
void CoverageNeed::teach(const Vec3& at, double surprise) {
  double nearest = std::numeric_limits<double>::infinity();  // squared [m^2]
  space_->points().for_each_within(at, limits_[0].sparse_distance,
                                   [&](std::uint32_t id, const Vec3&, double squared) {
                                     if (id < known_) nearest = std::min(nearest, squared);
                                   });
  for (std::size_t s = 0; s < scales; ++s) {
    if (nearest <= limits_[s].sparse_distance * limits_[s].sparse_distance) continue;
    seen_[s] += 1;
    missed_[s] += surprise > 1 ? 1 : 0;
    return;
  }
}

// Shares of misses by Laplace's rule with a prior. A coarser spacing gets at least the share of a finer one:
// where a fine spacing misses, a coarser one misses too.
void CoverageNeed::weigh_scales(bool with_stiffness) {
  constexpr double strength = 4;  // states that the prior counts as
  const std::array<double, scales> prior =
      with_stiffness ? std::array{0.9, 0.5, 0.15} : std::array{0.9, 0.7, 0.4};
  for (std::size_t s = scales; s-- > 0;) {
    importance_[s] = (missed_[s] + strength * prior[s]) / (seen_[s] + strength);
    if (s + 1 < scales) importance_[s] = std::max(importance_[s], importance_[s + 1]);
  }
}

// A prediction with deviation s puts 1 / (1 + (s / 2 h)^2) of its weight on the predicted point, and the rest on the
// places of the box around it, as a Gaussian of width s.
void CoverageNeed::weigh(const PlannerView& view) {
  const double solve = std::max(view.solve_seconds, 1e-3), h = view.space.options().spacing;
  const Box& box = view.space.options().box;
  const auto weight_at = weigh_box(view, solve, options_.path_share, box_);
  places_.clear();
  std::vector<double> near(box_.size());
  for (const Prediction& p : view.predicted) {
    const double weight = weight_at(p.horizon);
    const double sure = sureness(p.deviation, h), width = std::max(p.deviation, h);
    Place place{.at = folded(p.at, box), .weight = weight * sure};
    const auto nearest = view.space.points().nearest(
        place.at, limits_[0].sparse_distance);  // the coarsest scale's, the largest distance
    for (std::size_t s = 0; s < scales; ++s)
      place.kept[s] = regions_.empty() ? label_at(view.space, place.at, limits_[s], nearest)
                                       : KeptLabel{regions_[s].label_at(place.at)};
    places_.push_back(place);
    if (!(weight > 0) || sure > 0.99) continue;
    constexpr double nothing = -40;  // e^-40, 4e-18
    const double exponent = -0.5 / (width * width);
    double sum = 0;
    for (std::size_t i = 0; i < box_.size(); ++i) {
      const double e = exponent * (box_[i].at - place.at).squaredNorm();
      sum += near[i] = e > nothing ? std::exp(e) : 0;
    }
    for (std::size_t i = 0; sum > 0 && i < box_.size(); ++i)
      box_[i].weight += weight * (1 - sure) * near[i] / sum;
  }
  places_.insert(places_.end(), box_.begin(), box_.end());
}

void CoverageNeed::shuffle_labels() {
  const std::uint64_t step = random::mix(options_.seed, known_);
  for (std::size_t i = places_.size(); i > 1; --i) {
    const std::size_t j = random::mix(step, i) % i;
    std::swap(places_[i - 1].kept, places_[j].kept);
  }
}

void CoverageNeed::look(const PlannerView& view) {
  if (space_ != &view.space || known_ > view.space.size()) begin(view.space);
  learn(view.surprises);
  weigh_scales(view.with_stiffness);
  weigh(view);
  if (options_.shuffle) shuffle_labels();
  gather_needs();
  gather_corners(view);
  pend(view.pending);
}

// The places of the path come first, then those of the box.
double CoverageNeed::lack_of(std::size_t place, std::size_t s) const {
  const std::size_t on_path = places_.size() - box_.size();
  if (regions_.empty() || place < on_path) return lack(places_[place].kept[s].label, static_cast<int>(s));
  double sum = 0;
  for (const Label label : all_labels)
    sum += std::max(0.0, regions_[s].share(place - on_path)[label]) * lack(label, static_cast<int>(s));
  return sum;
}

void CoverageNeed::gather_needs() {
  NeedLeft::Needs inverses;
  for (std::size_t s = 0; s < scales; ++s)
    inverses[s] = 1 / std::pow(reach * multiples[s] * space_->options().spacing, 2);
  std::vector<Vec3> at;
  std::vector<NeedLeft::Needs> all;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    NeedLeft::Needs needs;
    for (std::size_t s = 0; s < scales; ++s) needs[s] = places_[i].weight * importance_[s] * lack_of(i, s);
    if (!(*std::ranges::max_element(needs) > least_need)) continue;
    at.push_back(places_[i].at);
    all.push_back(needs);
  }
  left_.begin(at, all, inverses);
}

// Samples the path in steps of half a spacing; each segment has the weight of the prediction at its end.
void CoverageNeed::gather_corners(const PlannerView& view) {
  corners_.clear();
  if (!view.in_cells || view.predicted.empty()) return;
  const double h = view.space.options().spacing, solve = std::max(view.solve_seconds, 1e-3);
  const Box& box = view.space.options().box;
  double sum = 0;
  for (const Prediction& p : view.predicted) sum += urgency(p.horizon, solve);
  std::map<std::tuple<long, long, long>, double> cells;  // the most urgent moment in each
  Vec3 last = folded(view.predicted[0].at, box);
  for (const Prediction& p : view.predicted) {
    const Vec3 next = folded(p.at, box);
    const double weight = options_.path_share * urgency(p.horizon, solve) / sum;
    const int steps = 1 + static_cast<int>(std::min((next - last).norm() / (0.5 * h), 1000.0));
    for (int i = 1; i <= steps; ++i) {
      const Vec3 cell = ((last + (next - last) * i / steps) / h).array().floor();
      double& most = cells[{std::lround(cell[0]), std::lround(cell[1]), std::lround(cell[2])}];
      most = std::max(most, weight);
    }
    last = next;
  }
  for (const auto& [cell, weight] : cells) {
    std::vector<Vec3> lacking;
    for (int corner = 0; corner < 8; ++corner) {
      const auto [i, j, k] = cell;
      const Vec3 at =
          h * Vec3(static_cast<double>(i + (corner & 1)), static_cast<double>(j + (corner >> 1 & 1)),
                   static_cast<double>(k + (corner >> 2)));
      if (!space_->find(at).valid()) lacking.push_back(at);
    }
    for (const Vec3& at : lacking) corners_.emplace_back(at, weight / static_cast<double>(lacking.size()));
  }
}

void CoverageNeed::pend(std::span<const Vec3> pending) {
  left_.set(pending);
}

void CoverageNeed::worth(std::span<const Candidate> candidates, std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  if (!space_) return;
  const std::size_t count = candidates.size();
  if (count == 0) return;
  const double h = space_->options().spacing;
  const CandidateRows rows(candidates, reach * h);
  std::vector<double> worth(count, 0.0);
  double inverses[scales];
  for (std::size_t s = 0; s < scales; ++s) inverses[s] = 1 / std::pow(reach * multiples[s] * h, 2);
  for (std::size_t i = 0; i < left_.places(); ++i) {
    NeedLeft::Needs needs = left_.left(i);
    double farthest = 0;  // distance from which a state still mends the place
    for (std::size_t s = 0; s < scales; ++s) {
      if (!(needs[s] > least_need)) needs[s] = 0;
      if (needs[s] > 0) farthest = std::max(farthest, reach * multiples[s] * h);
    }
    if (!(farthest > 0)) continue;
    const Vec3 q = left_.at(i);
    rows.near(q, 1.001 * farthest, [&](std::size_t first, std::size_t last) {
      in_best_set<add_worth>(first, last, count, rows.xyz(), q.data(), needs.data(), inverses, worth.data());
    });
  }
  for (std::size_t place = 0; place < count; ++place) out[rows.candidate(place)] = worth[place];
  for (const auto& [at, more] : corners_)
    for (std::size_t i = 0; i < count; ++i)
      if ((candidates[i].at - at).squaredNorm() < 1e-12 * h * h) out[i] += more;
}

}  // namespace forefeel
