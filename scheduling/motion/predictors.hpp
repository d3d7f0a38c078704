#pragma once
// The built-in predictors (built_in_predictors.cpp, learning_predictors.cpp, recurrent_net.cpp).

#include <memory>

#include "scheduling/common/factory_context.hpp"

namespace forefeel {

class Predictor;

std::unique_ptr<Predictor> make_constant_velocity(FactoryContext& context);
std::unique_ptr<Predictor> make_kalman(FactoryContext& context);
std::unique_ptr<Predictor> make_minimum_jerk(FactoryContext& context);
std::unique_ptr<Predictor> make_autoregressive(FactoryContext& context);
std::unique_ptr<Predictor> make_past(FactoryContext& context);
std::unique_ptr<Predictor> make_network(FactoryContext& context);

}  // namespace forefeel
