#pragma once
// The built-in predictors (built_in_predictors.cpp).

#include <memory>

#include "scheduling/common/factory_context.hpp"

namespace forefeel {

class Predictor;

std::unique_ptr<Predictor> make_constant_velocity(FactoryContext& context);
std::unique_ptr<Predictor> make_kalman(FactoryContext& context);

}  // namespace forefeel
