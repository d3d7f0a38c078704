#include "approx/neighbours.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {
namespace {

constexpr double loyalty = 0.95;  // of the distance of a member of the last set
constexpr std::size_t most_candidates = 8192;
constexpr double infinite = std::numeric_limits<double>::infinity();

// In spacings:
constexpr double shell = 2.5;       // behind the nearest state, of those that decide where a side lies
constexpr double pulled_to = 0.25;  // before the nearest state of a side,
constexpr double pulled_r = 2;      // and for r, which a layer or two suit well, before a single side
constexpr double band = 0.4;        // of the key, over which a weight rises,
constexpr double band_r5 = 1.2;     // and of r^5 on force, which trusts its outermost states farthest of all
constexpr double farthest = 32;     // a far side
constexpr double fading = 8;        // before that, over which it goes
// Cosine to the axis within which a state counts for both sides.
constexpr double between = 0.3;
constexpr double least_weight = 1e-4;
// Keys are measured from a little aside, so that states of a lattice come one by one, not shell by shell.
const Vec3 aside(0.17, -0.11, 0.07);
constexpr double least_ratio = 0.1;  // d_1 / d_2 from which the far side comes in

// From 0 to 1 on [0, 1], twice differentiable.
double rise(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

}  // namespace

NeighbourSelector::NeighbourSelector(const StateSpace& space, const ModelOptions& options)
    : space_(space), n_(options.neighbours), weighted_(weighted_neighbours(options)), most_(most_neighbours(options)),
      rule_(options.select), h_(space.options().spacing),
      pulled_(options.kernel == Kernel::linear ? pulled_r : pulled_to),
      band_(options.kernel == Kernel::quintic && options.data == Data::force ? band_r5 : band) {
  const std::size_t room = std::max(most_candidates, 2 * weighted_ + 16);
  found_.reserve(room);
  candidates_.reserve(room);
  keys_.reserve(room);
  last_.reserve(most_);
  chosen_.reserve(2 * most_ + 4);
}

void NeighbourSelector::forget() {
  last_.clear();
}

// The candidates: the states within the radius of the HIP, or the `least` nearest to it if those are more.
void NeighbourSelector::gather(const Vec3& hip, std::size_t least, double radius) {
  found_.clear();
  if (radius > 0) space_.within(hip, radius, found_);
  if (found_.size() < least)
    space_.nearest(hip, least, found_);
  else if (found_.size() > most_candidates)
    space_.nearest(hip, most_candidates, found_);
  candidates_.clear();
  for (const StateId id : found_) {
    const Vec3 away = space_[id].at - hip;
    const double distance = away.norm();
    candidates_.push_back({distance, id, distance > 0 ? Vec3(away / distance) : Vec3(Vec3::Zero()), {0, 0}, {0, 0}});
  }
}

void NeighbourSelector::keep_first(std::size_t count) {
  const auto before = [](const Candidate& a, const Candidate& b) {
    return a.key != b.key ? a.key < b.key : a.id < b.id;
  };
  count = std::min(count, candidates_.size());
  const auto middle = candidates_.begin() + static_cast<std::ptrdiff_t>(count);
  if (middle != candidates_.end()) std::nth_element(candidates_.begin(), middle, candidates_.end(), before);
  for (auto c = candidates_.begin(); c != middle; ++c) chosen_.push_back({c->id, 1, 1});
}

void NeighbourSelector::take_nearest(const Vec3& hip) {
  gather(hip, n_ + n_ / 4 + 8, 0);
  for (Candidate& c : candidates_)
    if (std::ranges::binary_search(last_, c.id)) c.key *= loyalty;
  keep_first(n_);
}

// Of the directions to the nearest states: their second moments, which two opposite sides share, and their
// mean, which a single side has.
Vec3 NeighbourSelector::main_axis(double nearest) const {
  Mat3 second = Mat3::Zero();
  Vec3 mean = Vec3::Zero();
  double total = 0;
  for (const Candidate& c : candidates_) {
    const double near = 1 - (c.key - nearest) / (shell * h_);
    if (near <= 0) continue;
    const double w = near * near * c.key / (c.key + 0.1 * h_);  // a state at the HIP has no direction
    second += w * c.towards * c.towards.transpose();
    mean += w * c.towards;
    total += w;
  }
  if (!(total > 0)) return Vec3::UnitX();
  mean /= total;
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(Mat3(second / total + 2 * mean * mean.transpose()));
  return solver.eigenvectors().col(2);
}

NeighbourSelector::Side NeighbourSelector::side(std::size_t s) const {
  Side found{infinite, Vec3::Zero()};
  for (const Candidate& c : candidates_) found.distance = std::min(found.distance, c.key + c.beyond[s]);
  for (const Candidate& c : candidates_) {
    const double near = 1 - (c.key + c.beyond[s] - found.distance) / (shell * h_);
    if (near > 0) found.towards += near * near * c.towards;
  }
  if (found.towards.norm() > 0) found.towards.normalize();
  return found;
}

// The weights in a side that has `count` members.
void NeighbourSelector::weigh(std::size_t s, const Vec3& centre, double count) {
  const Vec3 from = centre + h_ * aside;
  keys_.clear();
  for (Candidate& c : candidates_) {
    if (c.beyond[s] == infinite) continue;
    c.beyond[s] += (space_[c.id].at - from).norm();
    keys_.push_back(c.beyond[s]);
  }
  if (keys_.empty()) return;
  const auto rank = static_cast<std::size_t>(count);
  double end = infinite;
  if (rank < keys_.size()) {
    const auto at = keys_.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(keys_.begin(), at, keys_.end());
    const double key = *at, next = rank + 1 < keys_.size() ? *std::min_element(at + 1, keys_.end()) : key + h_;
    end = key + (count - double(rank)) * (next - key);
  }
  for (Candidate& c : candidates_)
    if (c.beyond[s] < end) c.weight[s] = rise((end - c.beyond[s]) / (band_ * h_));
}

void NeighbourSelector::take_sides(const Vec3& hip) {
  found_.clear();
  space_.nearest(hip, 1, found_);
  const double nearest = (space_[found_.front()].at - hip).norm();
  const double reach = 1.2 + 1.2 * std::cbrt(0.5 * double(weighted_));  // of a half ball of n, in spacings
  const double limit = std::max(farthest * h_, nearest + fading * h_);
  gather(hip, weighted_ + weighted_ / 4 + 8, std::max(nearest + reach * h_, std::min(nearest / least_ratio, limit)));

  const Vec3 axis = main_axis(nearest);
  for (Candidate& c : candidates_)
    for (const std::size_t s : {0u, 1u}) {
      const double of_it = rise(0.5 + 0.5 * c.towards.dot(s == 0 ? axis : Vec3(-axis)) / between);
      c.beyond[s] = of_it > 1e-3 ? 0.5 * h_ * (1 / of_it - 1) : infinite;
    }
  Side sides[2] = {side(0), side(1)};
  const std::size_t far = sides[0].distance <= sides[1].distance ? 1 : 0;
  const double d1 = sides[1 - far].distance, d2 = sides[far].distance;
  if (d2 < limit && d1 > least_ratio * d2)
    bridge_ = (d1 / d2 - least_ratio) / (1 - least_ratio) * std::min(1.0, (limit - d2) / (fading * h_));
  const double all = double(most_ - 1), second = bridge_ * all * d1 / (d1 + d2);
  const double pulled = pulled_ + bridge_ * (pulled_to - pulled_);
  for (const std::size_t s : {1 - far, far}) {
    const double count = bridge_ == 0 && s != far ? all : s == far ? second : all - second;
    if (count > 0) weigh(s, hip + std::max(0.0, sides[s].distance - pulled * h_) * sides[s].towards, count);
  }
  for (const Candidate& c : candidates_) {
    const std::size_t near = 1 - far;
    const double weight = 1 - (1 - c.weight[0]) * (1 - c.weight[1]);
    if (weight > least_weight) chosen_.push_back({c.id, weight, c.weight[near]});
  }
}

Label NeighbourSelector::select(const Vec3& hip, std::vector<Neighbour>& out) {
  out.clear();
  bridge_ = 0;
  if (space_.empty()) return Label::blank;
  const Label label = space_.label(hip);
  chosen_.clear();
  if (rule_ == Select::nearest) {
    space_.nearest(hip, n_, found_);
    for (const StateId id : found_) chosen_.push_back({id, 1, 1});
  } else if (label == Label::safe || space_.size() <= n_ || n_ == 1) {
    take_nearest(hip);  // where all fit there is nothing to choose, and of one neighbour nothing to weigh
  } else {
    take_sides(hip);
  }
  std::ranges::sort(chosen_, {}, &Neighbour::id);
  if (chosen_.size() > most_) chosen_.resize(most_);
  last_.clear();
  for (const Neighbour& member : chosen_) last_.push_back(member.id);
  out.assign(chosen_.begin(), chosen_.end());
  return label;
}

}  // namespace forefeel
