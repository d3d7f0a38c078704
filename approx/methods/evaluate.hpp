#pragma once
// Forces at points from known states: the computation of `forefeel evaluate`.
//
//   const std::vector<State> states = measured_states(positions, forces);
//   const Evaluation found = evaluate(states, points, {});       // states without stiffness: the model is
//                                                                // chosen (auto_model.hpp)
//   found.made.forces;  found.chosen->p95;                       // [N]; the error to expect [N]

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "approx/methods/auto_model.hpp"
#include "approx/methods/older_methods.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/states/check_solves.hpp"
#include "geometry/states/repeated_states.hpp"

namespace forefeel {

class OfflineBars;

struct EvaluateOptions {
  // True: the model is chosen (auto_model.hpp), except for what `model` fixes. Not given: the model is chosen if no
  // state has a stiffness and none of method, kernel, data, neighbours and ridge is given.
  std::optional<bool> choose = {};
  std::optional<Method> method = {};       // rbf if not given
  ModelWishes model = {};                  // its neighbours, of rbf_network: the number of centres
  bool choose_ridge = false;               // by leaving out single states (leave_one_out.hpp)
  bool bars = false;                       // error bars of each point, for method rbf only (error_bar.hpp)
  double spacing = unknown;                // h [m]; unknown: the median distance of the states
  KnownNoise noise = {};                   // of measured states; else it is estimated
  std::optional<FieldOptions> field = {};  // that of an earlier evaluation of the same states and noise
  std::optional<double> stiffest =
      {};  // of measured states, across them [N/m]; else three times that along them
  // Check solves are not used as states: within their box, their errors give the bars.
  CheckSolves checks = {};
  // Called by one thread with what is being done, and its share done; NaN: not known.
  std::function<void(std::string_view, double)> show = {};
};

// Error bars of the points and the measurement behind them. Also the number of points that lie farther from the states
// than any held-out force; inside and outside are compared separately. At these points the bars are extrapolated.
struct EvaluatedBars {
  std::vector<std::array<double, 3>> at;        // half-widths of 90, 95 and 99 % [N]
  std::shared_ptr<const OfflineBars> measured;  // error/error_bar.hpp
  std::size_t beyond = 0;
  std::size_t outside = 0;  // points outside the states
};

struct Evaluation {
  EvaluatedPoints made = {};
  Method method = Method::rbf;
  MethodOptions options = {};            // as used; .model of rbf and offline_rbf
  std::size_t states = 0;                // known positions
  std::size_t heaped = 0;                // rows of heaps (geometry/states/heaps.hpp)
  bool far_row_left_out = false;         // measured: one far from all others, and from all points
  RepeatedStates repeated = {};          // states that contradict each other are averaged
  std::optional<AutoModel> chosen = {};  // where the model was chosen
  std::optional<FieldOptions> field =
      {};                   // of measured states, if bars or a choice ask for it: law and noise
  SharedError shared = {};  // of measured states; part of bars and of the expected error
  std::optional<EvaluatedBars> bars = {};          // if requested and the method has them
  double fit_us = unknown, evaluate_ns = unknown;  // medians
};

// InputError if no state is usable, or if an option does not fit the states; its key is the name of the option
// ("--neighbours").
Evaluation evaluate(std::span<const State> states, std::span<const Vec3> points,
                    const EvaluateOptions& options);

// Measured states; stiffness: of each position, or empty.
std::vector<State> measured_states(std::span<const Vec3> positions, std::span<const Vec3> forces,
                                   std::span<const Mat3> stiffness = {});

}  // namespace forefeel
