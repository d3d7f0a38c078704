#include "scheduling/policy/error_need.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/policy/candidate_rows.hpp"
#include "scheduling/policy/need_policy.hpp"

namespace forefeel {

namespace {

constexpr double nearest_of_all = 0.05;  // delta below which the error is taken as that there [spacings]
// The prior of a, b, c with its strength, of v with its strength [states]. Fits to the errors at 320 to 780 states of
// three bodies gave a -3.7 to -1.5, b 1.1 to 1.9, c -0.2 to 2.3 and v 0.8 to 1.3.
const Eigen::Vector3d prior(-2.5, 1.6, 1.3), strength(4, 8, 4);
constexpr double prior_deviation = 1.2, deviation_strength = 6;

}  // namespace

double log_distance(double delta_over_h) {
  return std::log(std::max(delta_over_h, nearest_of_all));
}

ErrorFit::ErrorFit()
    : normal_(strength.asDiagonal()),
      right_(strength.cwiseProduct(prior)),
      fit_(prior),
      squares_(deviation_strength * prior_deviation * prior_deviation),
      count_(deviation_strength) {}

double ErrorFit::learn(double delta_over_h, double side, double log_error) {
  const Eigen::Vector3d row(1, log_distance(delta_over_h), side);
  const double residual = log_error - row.dot(fit_);
  squares_ += std::min(residual * residual, 16.0);
  ++count_;
  normal_ += row * row.transpose();
  right_ += log_error * row;
  fit_ = normal_.ldlt().solve(right_);
  fit_[1] = std::max(fit_[1], 0.5);  // an error that does not grow away from states orders nothing
  return residual;
}

double ErrorFit::median(double delta_over_h, double side) const {
  return std::exp(fit_.dot(Eigen::Vector3d(1, log_distance(delta_over_h), side)));
}

double ErrorFit::deviation() const {
  return std::sqrt(squares_ / count_);
}

namespace {

constexpr std::size_t around = 8;        // states that tell inside from outside
constexpr std::size_t most_cubes = 300;  // of the box
constexpr std::size_t most_residuals = 300;
constexpr double far = 5;             // distance of a state where none is known [spacings]
constexpr double least_share = 1e-5;  // of the need of all places: below it a place needs nothing
constexpr double local = 3;           // width of r [spacings]
constexpr double local_strength = 2;  // residuals that r = 0 counts as
constexpr double cautious = 4;        // median of the estimate of jets over the error
constexpr double jet_power = 4;       // of the distance, in the error of a jet

double normal_share(double x) {
  return 0.5 * std::erfc(-x * M_SQRT1_2);
}

}  // namespace

void ErrorNeed::begin(const StateSpace& space) {
  space_ = &space;
  spacing_ = space.options().spacing;
  known_ = 0;
  asked_ = static_cast<std::size_t>(-1);
  fit_ = ErrorFit();
  residuals_.clear();
  box_.clear();
  const Box& box = space.options().box;
  const Vec3 size = box.size();
  double side = 2 * spacing_;
  const auto cubes = [&] { return (size / side).array().ceil().max(1.0).eval(); };
  while (cubes().prod() > most_cubes) side *= 1.1;
  const Eigen::Array3d count = cubes();
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k) {
        Place place{.at = box.low + (size.array() * ((Eigen::Array3d(i, j, k) + 0.5) / count)).matrix()};
        see(place, 0);
        box_.push_back(place);
      }
}

// delta and side of a place, from the states with ids below `before`.
void ErrorNeed::see(Place& place, std::size_t before) {
  place.delta = place.reach = far * spacing_;
  place.side = 1;
  space_->nearest(place.at, around + (space_->size() - before), near_);
  Vec3 mean = Vec3::Zero();
  double distance = 0, count = 0;
  for (const StateId id : near_) {
    if (id.value >= before || count >= around) continue;
    const Vec3 away = (*space_)[id].at - place.at;
    if (count == 0) place.delta = std::min(place.delta, away.norm());
    mean += away;
    distance += away.norm();
    place.reach = away.norm();
    ++count;
  }
  if (count < around) place.reach = std::numeric_limits<double>::infinity();
  if (distance > 0 && count >= 4) place.side = mean.norm() / distance;
}

void ErrorNeed::add(const Residual& residual, double sign, Place& place) const {
  const double width = local * spacing_;
  const double near = sign * std::exp(-(residual.at - place.at).squaredNorm() / (2 * width * width));
  place.residuals += near * residual.value;
  place.residual_count += near;
}

void ErrorNeed::remember(const Residual& residual) {
  if (residuals_.size() == most_residuals) {
    for (Place& place : box_) add(residuals_.front(), -1, place);
    residuals_.erase(residuals_.begin());
  }
  for (Place& place : box_) add(residual, 1, place);
  residuals_.push_back(residual);
}

// Takes in the new states: their errors teach, and places near them are seen anew.
void ErrorNeed::learn(const PlannerView& view) {
  const std::size_t first = known_;
  for (; known_ < space_->size(); ++known_) {
    if (known_ >= view.surprises.size() || !std::isfinite(view.surprises[known_])) continue;
    Place seen{.at = (*space_)[StateId{static_cast<std::uint32_t>(known_)}].at};
    see(seen, known_);
    const double error = std::clamp(std::log(double(view.surprises[known_]) + 1e-9), -8.0, 8.0);
    remember({seen.at, fit_.learn(seen.delta / spacing_, seen.side, error)});
  }
  for (std::size_t k = first; k < known_; ++k) {
    const Vec3 at = (*space_)[StateId{static_cast<std::uint32_t>(k)}].at;
    for (Place& place : box_)
      if ((at - place.at).norm() < place.reach) see(place, known_);
  }
}

// An uncertain prediction passes a part of its weight to the cubes around it.
void ErrorNeed::weigh(const PlannerView& view) {
  const Box& box = view.space.options().box;
  const auto weight_at = weigh_box(view, solve_, options_.path_share, box_);
  places_.clear();
  for (const Prediction& p : view.predicted) {
    const double weight = weight_at(p.horizon);
    const double sure = sureness(p.deviation, spacing_);
    Place place{.at = folded(p.at, box), .weight = weight * sure};
    see(place, known_);
    for (const Residual& residual : residuals_) add(residual, 1, place);
    places_.push_back(place);
    const double width = std::max(p.deviation, spacing_), exponent = -0.5 / (width * width);
    double sum = 0;
    std::vector<double> near;
    for (const Place& cube : box_) near.push_back(std::exp(exponent * (cube.at - place.at).squaredNorm()));
    for (const double n : near) sum += n;
    for (std::size_t i = 0; sum > 0 && i < box_.size(); ++i)
      box_[i].weight += weight * (1 - sure) * near[i] / sum;
  }
  places_.insert(places_.end(), box_.begin(), box_.end());
}

// The estimates of the box change with the states only.
void ErrorNeed::ask_jets(const PlannerView& view) {
  jets_ = static_cast<bool>(view.estimate) && std::isfinite(view.estimate(view.hip.at));
  content_ = jets_;
  if (!jets_) return;
  if (asked_ != known_) {
    asked_ = known_;
    std::vector<double> growth;
    for (Place& place : box_) {
      place.estimate = view.estimate(place.at);
      if (place.delta > 0) growth.push_back(place.estimate / std::pow(place.delta, jet_power));
    }
    growth_ = growth.empty() ? 0 : median(std::move(growth));
  }
  const std::size_t ahead = places_.size() - box_.size();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    places_[i].estimate = i < ahead ? view.estimate(places_[i].at) : box_[i - ahead].estimate;
    content_ = content_ && !(places_[i].estimate > 1);
  }
}

double ErrorNeed::exponent(const Place& place, double log_scale, double share) const {
  if (!jets_)
    return (log_scale + fit_.slope() * log_distance(place.delta / spacing_ * share)) / fit_.deviation();
  const double left = growth_ * std::pow(place.delta * share, jet_power);
  return std::log((share < 1 ? std::min(place.estimate, left) : place.estimate) / cautious + 1e-9);
}

// The needs of all places, as tables over the distance of the nearest state.
void ErrorNeed::estimate() {
  std::vector<double> log_scale;  // ln m without the part of delta
  for (const Place& place : places_)
    log_scale.push_back(fit_.intercept(place.side) +
                        place.residuals / (place.residual_count + local_strength));
  if (options_.shuffle) {  // estimates change places, with their distances
    const std::uint64_t step = random::mix(options_.seed, known_);
    for (std::size_t i = places_.size(); i > 1; --i) {
      const std::size_t j = random::mix(step, i) % i;
      std::swap(log_scale[i - 1], log_scale[j]);
      std::swap(places_[i - 1].delta, places_[j].delta);
      std::swap(places_[i - 1].estimate, places_[j].estimate);
    }
  }
  needs_.clear();
  double all = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Need need{.at = places_[i].at, .delta = places_[i].delta};
    for (int k = 0; k <= levels; ++k) {
      const double share = static_cast<double>(k) / levels;
      need.table[static_cast<std::size_t>(k)] =
          places_[i].weight * normal_share(exponent(places_[i], log_scale[i], share));
    }
    all += need.table[levels];
    needs_.push_back(need);
  }
  std::erase_if(needs_, [&](const Need& need) { return !(need.table[levels] > least_share * all); });
}

void ErrorNeed::look(const PlannerView& view) {
  if (space_ != &view.space || known_ > view.space.size()) begin(view.space);
  solve_ = std::max(view.solve_seconds, 1e-3);
  learn(view);
  weigh(view);
  ask_jets(view);
  estimate();
  pend(view.pending);
}

void ErrorNeed::pend(std::span<const Vec3> pending) {
  needs_left_.clear();
  for (const Need& need : needs_) {
    double nearest = need.delta;
    for (const Vec3& p : pending) nearest = std::min(nearest, (p - need.at).norm());
    if (nearest == need.delta) {
      needs_left_.push_back(need);
      continue;
    }
    Need left{.at = need.at, .delta = nearest};
    for (int k = 0; k <= levels; ++k) {
      const double place = nearest / need.delta * k;
      const int below = std::min(static_cast<int>(place), levels - 1);
      const double w = place - below;
      const auto row = static_cast<std::size_t>(below);
      left.table[static_cast<std::size_t>(k)] = (1 - w) * need.table[row] + w * need.table[row + 1];
    }
    needs_left_.push_back(left);
  }
}

void ErrorNeed::worth(std::span<const Candidate> candidates, std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  const std::size_t count = candidates.size();
  if (count == 0) return;
  const CandidateRows rows(candidates, 2 * spacing_);
  const double *x = rows.xyz(), *y = x + count, *z = y + count;
  std::vector<double> worth(count, 0.0);
  for (const Need& need : needs_left_) {
    const double squared = need.delta * need.delta, scale = levels / need.delta;
    rows.near(need.at, need.delta, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const double d2 = (Vec3(x[i], y[i], z[i]) - need.at).squaredNorm();
        if (!(d2 < squared)) continue;
        const double place = std::sqrt(d2) * scale;
        const int below = std::min(static_cast<int>(place), levels - 1);
        const double w = place - below;
        const auto row = static_cast<std::size_t>(below);
        worth[i] += need.table[levels] - (1 - w) * need.table[row] - w * need.table[row + 1];
      }
    });
  }
  for (std::size_t i = 0; i < count; ++i) out[rows.candidate(i)] = worth[i] / solve_;
}

}  // namespace forefeel
