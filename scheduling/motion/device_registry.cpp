// register_device() and make_device() of device.hpp. They have their own file because the built-in devices
// include that header.

#include "geometry/common/dense.hpp"
#include "scheduling/motion/device.hpp"

#include <fmt/format.h>

#include "scheduling/common/registry.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/path_device.hpp"
#include "scheduling/motion/touch_surface.hpp"
#include "scheduling/motion/trace.hpp"

namespace forefeel {
namespace {

Registry<DeviceFactory>& devices() {
  static Registry<DeviceFactory> devices("device", {}, {"path", "trace", "hand", "replay"});
  return devices;
}

// The first sample onto the surface, the z axis along the normal there, then the offset in these axes.
void place_on_surface(const Vec3& wanted, const Vec3& offset, const FactoryContext& context, Trace& trace) {
  if (context.surface == nullptr)
    throw InputError("device", "register needs a surface, expected it with contact.anywhere only");
  const SurfacePoint place = context.surface->nearest(wanted);
  const Mat3 turn = turn_between(Vec3::UnitZ(), place.normal);
  const Vec3 first = trace.positions.front();
  for (Vec3& p : trace.positions) p = place.at + turn * (p - first + offset);
}

std::unique_ptr<Device> make(const PathMotion& motion, const FactoryContext& context) {
  return make_path_device(motion, context);
}

std::unique_ptr<Device> make(const TraceMotion& motion, const FactoryContext& context) {
  Trace trace = read_trace(found_from(context.folder, motion.file), motion.format);
  for (Vec3& p : trace.positions) p *= motion.scale;
  if (motion.placed)
    place_on_surface(*motion.placed, motion.offset, context, trace);
  else
    for (Vec3& p : trace.positions) p += motion.offset;
  return make_trace_device(std::move(trace));
}

std::unique_ptr<Device> make(const HandMotion& motion, const FactoryContext& context) {
  const HandMotion hand = drawn_hand(motion, context.seed);
  return make_hand_device(profile_of(hand.profile), make_path_device(hand.target, context), options_of(hand));
}

std::unique_ptr<Device> make(const Registered& device, const FactoryContext& context) {
  const auto factory = devices().find(device.name);
  if (!factory)
    throw InputError({.key = "device", .value = to_text(device)},
                     fmt::format("unknown kind '{}', expected {}", device.name, device_kinds()));
  return make_registered(*factory, "device", device, context);
}

}  // namespace

void register_device(const std::string& name, DeviceFactory factory) {
  devices().add(name, std::move(factory));
}

std::vector<std::string> registered_devices() {
  return devices().names();
}

std::string device_kinds() {
  const std::vector<std::string> more = registered_devices();
  if (more.empty()) return "path:NAME, trace:FILE or hand:PROFILE";
  return fmt::format("path:NAME, trace:FILE, hand:PROFILE or one of {}", fmt::join(more, ", "));
}

std::unique_ptr<Device> make_device(const DeviceSpec& device, const FactoryContext& context) {
  check(device);
  return std::visit([&](const auto& motion) { return make(motion, context); }, device.motion());
}

}  // namespace forefeel
