#pragma once
// A policy whose priorities are the needs that a state removes (coverage_need.hpp, error_need.hpp). Among states that
// remove none, those nearer to the predicted path come first.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

enum class NeedPath { predicted, true_one };  // true_one: the motion of the session is known beforehand

// Need: look(view), pend(positions), and worth(candidates, out).
template <class Need>
class NeedPolicy final : public Policy {
 public:
  template <class Options>
  NeedPolicy(std::string_view name, NeedPath path, Options options)
      : name_(name), path_(path), need_(std::move(options)) {}
  std::string_view name() const override { return name_; }
  bool reads_regions() const override { return false; }
  bool reads_surprises() const override { return true; }
  bool reads_future() const override { return path_ == NeedPath::true_one; }
  void look(const PlannerView& view) override { need_.look(view); }
  bool is_content() const override {
    if constexpr (requires { need_.is_content(); }) return need_.is_content();
    return false;
  }
  void pend(const PlannerView& view) override { need_.pend(view.pending); }
  double at_most(double priority) const override {
    return priority < nothing ? priority : std::max(priority, 2 * nothing);
  }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    double worth = 0;
    prioritise({&candidate, 1}, view, {&worth, 1});
    return worth;
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                  std::span<double> out) const override {
    need_.worth(candidates, out);
    const double h = view.space.options().spacing;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (out[i] < nothing) out[i] += nothing * h / (h + distance_to_path(candidates[i].at, view));
  }

 private:
  static constexpr double nothing = 1e-9;  // worth below which the distance decides
  std::string_view name_;
  NeedPath path_;
  Need need_;
};

// Weights of places on the predicted path, for policies that sum needs along it.

// A state requested now is known after T = solve [s], the time of a solve. Places that the hand reaches at about that
// time count most (t [s]: time until then). Places it passes earlier benefit less; places it reaches later can wait.
//   u = 1 / (1 + l^2) for l = (T - t) / T > 0, else 1 / (1 - l)     [1]
double urgency(double t, double solve);

// The share of a prediction's weight that its position keeps; the rest goes to its surroundings.
//   sure = 1 / (1 + (deviation / 2 h)^2)   for the spacing h [m]     [1]
double sureness(double deviation, double h);

// A hand that leaves the box is expected to turn back: a position predicted outside is mirrored at the faces of the
// box until it is inside.
Vec3 folded(const Vec3& x, const Box& box);

// Weighs the places of the box by the time to reach each. path_share of all weight is on the predicted path: the result
// is the weight of a prediction, by its horizon [s]. Before the hand has moved there is no path, and all weight is on
// the box: the first states spread over it.
template <class Place>
auto weigh_box(const PlannerView& view, double solve, double path_share, std::vector<Place>& box) {
  const bool truth = !view.predicted.empty() && view.predicted.back().deviation == 0;
  if (!truth && view.space.empty() && !(view.hip.velocity.norm() > 0)) path_share = 0;
  double on_path = 0, in_box = 0;
  for (const Prediction& p : view.predicted) on_path += urgency(p.horizon, solve);
  for (Place& place : box) in_box += place.weight = urgency(time_to_reach(place.at, view), solve);
  for (Place& place : box) place.weight *= in_box > 0 ? (1 - path_share) / in_box : 0;
  return [=](double horizon) { return on_path > 0 ? path_share * urgency(horizon, solve) / on_path : 0; };
}

// The need that remains at each place once the states being solved ("under way") are known, for each scale s:
//   left_s(q) = need_s(q) prod_p (1 - m_s(q, p)),    m_s(q, p) = (1 - |q - p|^2 inverse_s)_+
// where p runs over the states under way, in their order. The products are kept between calls, so adding a state, or
// removing a few of many, takes one pass over the places.

class NeedLeft {
 public:
  static constexpr std::size_t scales = 3;
  using Needs = std::array<double, scales>;

  // New places with their needs, nothing under way; inverses [1/m^2].
  void begin(std::span<const Vec3> at, std::span<const Needs> needs, const Needs& inverses);
  // Sets the complete list of states under way [m].
  void set(std::span<const Vec3> under_way);

  std::size_t places() const { return at_.size(); }
  Vec3 at(std::size_t i) const { return at_[i]; }
  Needs left(std::size_t i) const {
    Needs needs{};
    for (std::size_t s = 0; s < scales; ++s)
      if (const std::uint32_t j = rows_[s].of[i]; j != none) needs[s] = rows_[s].left[j];
    return needs;
  }
  std::span<const Vec3> under_way() const { return counted_; }

 private:
  void multiply(const Vec3& p);
  void anew(std::span<const Vec3> under_way);
  bool leave_out(std::span<const Vec3> under_way);

  static constexpr std::uint32_t none = 0xffffffffu;
  struct Row {  // of one scale: the places with a need there
    double inverse = 0;
    std::vector<std::uint32_t> place, of;  // #row -> place, #places -> row or none
    std::vector<double> xyz, need, left;   // one coordinate per row; #row
  };
  std::vector<Vec3> at_;
  std::array<Row, scales> rows_;
  std::vector<Vec3> counted_;  // the states under way
  // The longest recent list of states that contains all lists since, and its products. A shorter list is
  // obtained from them by division.
  std::vector<Vec3> all_;
  std::array<std::vector<double>, scales> all_left_;
};

}  // namespace forefeel
