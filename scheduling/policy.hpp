#pragma once
// What is solved next: a policy gives every candidate position a priority; the planner dispatches the highest.
// A policy of one's own is one file: derive, register, name it in the scene.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/state_space.hpp"

namespace forefeel {

struct HipSample {
  double t = 0;                      // [s]
  Vec3 at = Vec3::Zero();            // [m]
  Vec3 velocity = Vec3::Zero();      // [m/s]
};

// Where the HIP will be `horizon` seconds from now, with its standard deviation per axis.
struct Prediction {
  double horizon = 0;                // [s]
  Vec3 at = Vec3::Zero();            // [m]
  double deviation = 0;              // [m]
};

// What a policy may look at; immutable while it is asked.
struct PlannerView {
  const StateSpace& space;
  double now = 0;                                // [s]
  HipSample hip;
  std::span<const Prediction> predicted;         // by growing horizon, first is now
  double solve_seconds = 0.01;                   // running median of a solve [s]
  int workers = 1;
};

struct Candidate {
  Vec3 at = Vec3::Zero();            // where a state would be solved [m]
  Label region = Label::blank;       // label of the region it lies in
  double requested = 0;              // when it first became a candidate [s]
};

class Policy {
 public:
  virtual ~Policy() = default;
  virtual std::string_view name() const = 0;
  // Finite; larger is sooner. Called for every candidate at each planning step.
  virtual double priority(const Candidate& candidate, const PlannerView& view) const = 0;
};

struct PolicyOptions {
  std::uint64_t seed = 0;
};
using PolicyFactory = std::function<std::unique_ptr<Policy>(const PolicyOptions&)>;
void register_policy(std::string name, PolicyFactory factory);
std::vector<std::string> policy_names();
std::unique_ptr<Policy> make_policy(const std::string& name, const PolicyOptions& options);  // InputError lists names

}  // namespace forefeel
