#pragma once
// The built-in predictors, one file each: predictor_NAME.cpp.

#include <memory>

#include "scheduling/common/factory_context.hpp"

namespace forefeel {

class Predictor;

std::unique_ptr<Predictor> make_constant_velocity(FactoryContext& context);
std::unique_ptr<Predictor> make_kalman(FactoryContext& context);

}  // namespace forefeel
