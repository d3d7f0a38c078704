#pragma once
// Where the HIP will be, guessed from where it was.
//
// To write one: derive from Predictor, define observe() and predict(), register it under a name.
//
//   struct Still final : forefeel::Predictor {               // the hand stays where it is, give or take v * horizon
//     forefeel::HipSample last;
//     void observe(const forefeel::HipSample& sample) override { last = sample; }
//     forefeel::Prediction predict(double horizon) const override {
//       return {.horizon = horizon, .at = last.at, .deviation = 1e-3 + last.velocity.norm() * horizon};
//     }
//   };
//   const bool known = (forefeel::register_predictor("still", [](forefeel::FactoryContext&) {
//     return std::make_unique<Still>(); }), true);
//
// Scenes (session.predictor), studies and --predictor then know it.
//
// Order of calls: observe() for each new sample of the HIP, under the virtual clock each frame, under the real clock the
// newest whenever the planner gets to it; then predict() for several horizons, at least once between two samples.
// Thread: the planner's alone. It may allocate, but its time delays every decision: a few microseconds a call.
// Under the virtual clock it must be a function of the samples and the seed, so that a run repeats bit by bit.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual void observe(const HipSample& sample) = 0;     // times do not go back
  virtual Prediction predict(double horizon) const = 0;  // horizon seconds after the last sample, at least 0
};

// The predictor of a session: a name and the settings behind it.
using PredictorSpec = Registered;
using PredictorFactory = std::function<std::unique_ptr<Predictor>(FactoryContext&)>;

// From any thread and also before main() begins. InputError for a name that is taken.
void register_predictor(const std::string& name, PredictorFactory factory);
std::vector<std::string> predictor_names();  // sorted
// InputError lists the names.
std::unique_ptr<Predictor> make_predictor(const PredictorSpec& predictor, const FactoryContext& context = {});

}  // namespace forefeel
