#include "geometry/coverage/sited_labels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <utility>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr double least_cosine = 0.5;  // of two normals
constexpr double space_kept = 0.25;   // of the reach

}  // namespace

SitedLabels::SitedLabels(std::vector<SitedState> states, StateSpaceOptions spaces, double depth, double reach)
    : states_(std::move(states)), options_(std::move(spaces)), reach_(reach) {
  options_.box = {Vec3::Constant(-depth), Vec3::Constant(depth)};
}

Label SitedLabels::at(const SitedState& place, std::size_t known) {
  known = std::min(known, states_.size());
  if (!space_ || known_ != known || (middle_.site - place.site).norm() > space_kept * reach_)
    gather(place, known);
  return space_->label(turn_between(place.normal, middle_.normal) * place.x);
}

void SitedLabels::gather(const SitedState& place, std::size_t known) {
  space_.emplace(options_);
  known_ = known, middle_ = place;
  for (const SitedState& state : std::span(states_).first(known)) {
    if (!((state.site - place.site).norm() <= reach_) || !(state.normal.dot(place.normal) >= least_cosine))
      continue;
    State turned;
    turned.at = turn_between(state.normal, place.normal) * state.x;
    space_->insert(std::move(turned));
  }
}

}  // namespace forefeel
