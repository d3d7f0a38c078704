#pragma once
// A haptic device, real or simulated. It gives the position of the HIP (haptic interaction point, the tip) at
// any time, and receives the force that is sent.
//
// To write one: derive from Device, define position() and duration(), register it under a name.
//
//   struct Tap final : forefeel::Device {                    // in and out, `rate` times a second
//     double rate; forefeel::Vec3 deepest;
//     Tap(double r, const forefeel::Vec3& d) : rate(r), deepest(d) {}
//     forefeel::Vec3 position(double t, const forefeel::Vec3&) noexcept override {
//       return (0.5 - 0.5 * std::cos(6.2832 * rate * t)) * deepest;
//     }
//     double duration() const override { return std::numeric_limits<double>::infinity(); }
//   };
//   const bool known = (forefeel::register_device("tap", [](forefeel::FactoryContext& with) {
//     return std::make_unique<Tap>(with.arguments.number("rate", 1, 0.01, 20), 0.01 * with.inward);
//   }), true);
//
// In code, options.motion.device = Registered("tap", {{"rate", "2"}}) then selects it. Scenes, studies
// and --device know "tap" and "tap:rate=2" only in a command that is built with it; `forefeel` itself is not
// (apps/examples/command_policy.cpp).
// A measured motion: read_trace() and make_trace_device() in scheduling/motion/trace.hpp.
//
// Order of calls. make_plan() calls the factory once. Then it calls duration(), limits() and position() over the whole
// motion with force zero, to check it. All this is in the thread of its caller. The factory may throw: an InputError
// passes through; another exception becomes an InputError that names the device. run_session() calls position() frame
// by frame, from t = 0 again, and limits() after the last frame. The order is the same whether or not the device
// answers the force.
// Thread: the real-time loop (1 kHz) under the real clock, the session's thread under the virtual clock; never two at
// once. Forbidden in position(): memory allocation, locks, exceptions (they end the program), files, waiting. A
// position that is not finite is replaced by the last one and counted. Under the virtual clock the position must be a
// function of t, the forces so far and the seed, so that a run repeats bit by bit.

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/device_spec.hpp"
#include "scheduling/motion/loop_limit.hpp"

namespace forefeel {

struct DeviceLimits {
  double force = std::numeric_limits<double>::infinity();      // largest force the session sends [N]
  double stiffness = std::numeric_limits<double>::infinity();  // highest the device can render [N/m]
  // The device and the hand that holds it, where known. Limits the rendered stiffness under passivity control.
  LoopPlant plant = {};
};

class Device {
 public:
  virtual ~Device() = default;
  // Position of the HIP at frame time t [s], relative to rest [m]. force: what the last frame sent [N].
  // The motion starts at t = 0, at rest (x = 0). If t is smaller than in the call before, start over.
  virtual Vec3 position(double t, const Vec3& force) noexcept = 0;
  virtual double duration() const = 0;  // of the motion [s]; infinite for a motion without end
  // Whether the motion depends on the force. If so, the policy `clairvoyant` cannot run: it needs the motion
  // in advance.
  virtual bool answers_force() const { return false; }
  virtual DeviceLimits limits() const { return {}; }
};

using DeviceFactory = std::function<std::unique_ptr<Device>(FactoryContext&)>;
// May be called from any thread, and before main() begins. InputError for a name that is taken or built in.
void register_device(const std::string& name, DeviceFactory factory);
std::vector<std::string> registered_devices();  // sorted, without the built-in ones

// InputError for a value outside its range, an unreadable trace or an unregistered name.
std::unique_ptr<Device> make_device(const DeviceSpec& device, const FactoryContext& context);

// The accepted kinds, for the error message about an unknown one: "path:NAME, trace:FILE or hand:PROFILE", then the
// registered names.
std::string device_kinds();

}  // namespace forefeel
