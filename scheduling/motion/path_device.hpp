#pragma once
// A device that follows a closed curve at constant speed, whatever the force.

#include <memory>

#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/device_spec.hpp"

namespace forefeel {

class Device;

// The curve is scaled to the context's box or, with an `amplitude`, until its farthest point is that far from rest.
std::unique_ptr<Device> make_path_device(const PathMotion& motion, const FactoryContext& context);

}  // namespace forefeel
