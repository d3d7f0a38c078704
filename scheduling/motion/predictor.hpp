#pragma once
// Predicts the position of the HIP from its past positions.
//
// To write one: derive from Predictor, define observe() and predict(), register it under a name.
//
//   struct Still final : forefeel::Predictor {               // the hand stays here; deviation v * horizon
//     forefeel::HipSample last;
//     void observe(const forefeel::HipSample& sample) override { last = sample; }
//     forefeel::Prediction predict(double horizon) const override {
//       return {.horizon = horizon, .at = last.at, .deviation = 1e-3 + last.velocity.norm() * horizon};
//     }
//   };
//   const bool known = (forefeel::register_predictor("still", [](forefeel::FactoryContext&) {
//     return std::make_unique<Still>(); }), true);
//
// In code, options.motion.predictor = Registered("still") then selects it. Scenes, studies and options
// know the name only in a command built with it (apps/examples/command_policy.cpp); `forefeel` itself is not.
//
// Order of calls: observe() for each new sample of the HIP. After each sample, predict() is called at least
// once, for several horizons. Under the virtual clock there is a sample each frame; under the real clock the
// planner observes the newest sample at each of its steps. Thread: the planner's alone. It may allocate. Its time
// delays every decision: a call should take a few microseconds at most. Under the virtual clock the result must depend
// only on the samples and the seed, so that runs repeat bit by bit.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

struct Declared;

class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual void observe(const HipSample& sample) = 0;     // times do not go back
  virtual Prediction predict(double horizon) const = 0;  // horizon seconds after the last sample, at least 0
};

// The predictor of a session: a name and the settings behind it.
using PredictorSpec = Registered;
using PredictorFactory = std::function<std::unique_ptr<Predictor>(FactoryContext&)>;

// May be called from any thread, and before main() begins. InputError for a name that is taken.
void register_predictor(const std::string& name, PredictorFactory factory);
std::vector<std::string> predictor_names();  // sorted
bool is_built_in_predictor(const std::string& name);
std::vector<Declared> declared_predictors();  // with their meanings, for `forefeel help`
// Throws InputError for an unknown name; the error lists the known ones.
std::unique_ptr<Predictor> make_predictor(const PredictorSpec& predictor, const FactoryContext& context = {});

}  // namespace forefeel
