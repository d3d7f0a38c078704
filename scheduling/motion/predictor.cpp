#include "scheduling/motion/predictor.hpp"

#include "scheduling/common/registry.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {
namespace {

Registry<PredictorFactory>& predictors_known() {
  static Registry<PredictorFactory> predictors(
      "predictor",
      {{"kalman", make_kalman,
        "position, velocity and a fading acceleration; learns how long the hand keeps its direction"},
       {"constant-velocity", make_constant_velocity, "the hand keeps its velocity"},
       {"minimum-jerk", make_minimum_jerk, "past its peak speed, a movement ends as it began"},
       {"autoregressive", make_autoregressive,
        "each displacement from the last four, fitted to the motion so far"},
       {"past", make_past, "as the hand moved when it last came the same way"},
       {"network", make_network,
        "network:FILE, a recurrent net with these weights (train_network.py makes them)"}});
  return predictors;
}

}  // namespace

void register_predictor(const std::string& name, PredictorFactory factory) {
  predictors_known().add(name, std::move(factory));
}

std::vector<std::string> predictor_names() {
  return predictors_known().names();
}

bool is_built_in_predictor(const std::string& name) {
  return predictors_known().is_built_in(name);
}

std::vector<Declared> declared_predictors() {
  return predictors_known().declared();
}

std::unique_ptr<Predictor> make_predictor(const PredictorSpec& predictor, const FactoryContext& context) {
  return make_registered(predictors_known().at(predictor.name), "predictor", predictor, context);
}

}  // namespace forefeel
