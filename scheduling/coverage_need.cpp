#include "scheduling/coverage_need.hpp"

#include <algorithm>
#include <cmath>

#include "scheduling/random.hpp"

namespace forefeel {
namespace {

constexpr double reach = 1.5;                              // of a state, in spacings H
constexpr double surely = 2;                               // spacings: the path is as good as its deviation is below
constexpr int multiples[CoverageNeed::scales] = {4, 2, 1};   // H / h

double lack(Label label, int scale) {
  switch (label) {
    case Label::blank: return 1;
    case Label::gap: return 0.4;
    case Label::sparse: return scale == 0 ? 0.0 : 0.1;     // at 4 h the spacings below say it better
    case Label::safe: return 0;
  }
  return 0;
}

}  // namespace

CoverageNeed::CoverageNeed(NeedOptions options) : options_(options) {}
CoverageNeed::~CoverageNeed() = default;

void CoverageNeed::begin(const StateSpace& space) {
  space_ = &space;
  known_ = 0;
  box_.clear();
  StateSpaceOptions options = space.options();
  const double h = options.spacing;
  for (int s = 0; s < scales; ++s) {
    options.spacing = multiples[s] * h;
    spaces_[static_cast<std::size_t>(s)] = std::make_unique<StateSpace>(options);
  }
  // Cubes of about 2 h that fill the box; no more than some thousand of them.
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
}

void CoverageNeed::relabel(Place& place) const {
  for (std::size_t s = 0; s < scales; ++s)
    if (place.label[s] != Label::safe) place.label[s] = spaces_[s]->label(place.at);
}

// Labels never get worse, so what is safe at a spacing is not asked again.
void CoverageNeed::learn(const StateSpace& space) {
  if (known_ == space.size()) return;
  for (; known_ < space.size(); ++known_)
    for (auto& index : spaces_) {
      State bare = space[StateId{static_cast<std::uint32_t>(known_)}];
      bare.displacements.reset();
      index->insert(std::move(bare));
    }
  for (Place& place : box_) relabel(place);
}

// A state asked for now is there after T. Where the hand will be at about that time counts most; what it passes
// before is helped less, what it reaches later can wait. A path that is uncertain or leaves the box says less, and what
// it says less the box says more.
void CoverageNeed::weigh(const PlannerView& view) {
  const double solve = std::max(view.solve_seconds, 1e-3);
  const auto urgency = [&](double t, bool certain) {
    const double late = (solve - t) / solve;
    if (late > 0) return certain ? 0.0 : 1 / (1 + late * late);
    return 1 / (1 - late);
  };
  places_.clear();
  double on_path = 0, in_box = 0;
  const Box& box = view.space.options().box;
  const double h = view.space.options().spacing;
  for (const Prediction& p : view.predicted) {
    const double outside = (p.at - p.at.cwiseMax(box.low).cwiseMin(box.high)).norm();
    const double sure = 1 / (1 + std::pow(p.deviation / (surely * h), 2) + std::pow(outside / h, 2));
    const double weight = urgency(p.horizon, options_.know_path);
    Place place{.at = p.at, .weight = weight * sure};
    relabel(place);
    on_path += weight;
    places_.push_back(place);
  }
  const std::size_t path = places_.size();
  places_.insert(places_.end(), box_.begin(), box_.end());
  for (std::size_t i = path; i < places_.size(); ++i) {
    places_[i].weight = urgency(time_to_reach(places_[i].at, view), false);
    in_box += places_[i].weight;
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double sum = i < path ? on_path : in_box, share = i < path ? options_.path_share : 1 - options_.path_share;
    places_[i].weight *= sum > 0 ? share / sum : 0;
  }
}

void CoverageNeed::shuffle_labels() {
  const std::uint64_t step = mix(options_.seed, known_);
  for (std::size_t i = places_.size(); i > 1; --i) {
    const std::size_t j = mix(step, i) % i;
    std::swap(places_[i - 1].label, places_[j].label);
  }
}

void CoverageNeed::look(const PlannerView& view) {
  if (space_ != &view.space || known_ > view.space.size()) begin(view.space);
  learn(view.space);
  importance_ = view.with_stiffness ? std::array{1.0, 1.0, 0.01} : std::array{0.3, 1.0, 0.3};
  weigh(view);
  if (options_.shuffle) shuffle_labels();
}

void CoverageNeed::worth(std::span<const Candidate> candidates, std::span<const Vec3> pending,
                         std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  const double h = space_ ? space_->options().spacing : 1.0;
  for (const Place& place : places_)
    for (int s = 0; s < scales; ++s) {
      const double inverse = 1 / std::pow(reach * multiples[s] * h, 2);
      double need = place.weight * importance_[static_cast<std::size_t>(s)] *
                    lack(place.label[static_cast<std::size_t>(s)], s);
      for (const Vec3& p : pending) need *= 1 - std::max(0.0, 1 - (place.at - p).squaredNorm() * inverse);
      if (!(need > 1e-15)) continue;
      for (std::size_t i = 0; i < candidates.size(); ++i)
        out[i] += need * std::max(0.0, 1 - (place.at - candidates[i].at).squaredNorm() * inverse);
    }
}

}  // namespace forefeel
