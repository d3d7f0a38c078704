#pragma once
// A policy whose priorities are the needs that a state removes (coverage_need.hpp, error_need.hpp). Among states that
// remove none, those nearer to the predicted path come first.

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

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

}  // namespace forefeel
