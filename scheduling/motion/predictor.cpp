#include "scheduling/motion/predictor.hpp"

#include "scheduling/common/registry.hpp"
#include "scheduling/motion/predictors.hpp"

namespace forefeel {
namespace {

Registry<PredictorFactory>& registry() {
  static Registry<PredictorFactory> predictors(
      "predictor", {{"constant-velocity", make_constant_velocity}, {"kalman", make_kalman}});
  return predictors;
}

}  // namespace

void register_predictor(const std::string& name, PredictorFactory factory) {
  registry().add(name, std::move(factory));
}

std::vector<std::string> predictor_names() {
  return registry().names();
}

std::unique_ptr<Predictor> make_predictor(const PredictorSpec& predictor, const FactoryContext& context) {
  return make_registered(registry().at(predictor.name), "predictor", predictor, context);
}

}  // namespace forefeel
