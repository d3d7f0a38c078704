#pragma once
// A haptic device, real or simulated: where the HIP (the tip) is, and which force it was given.
//
// To write one: derive from Device, define position() and duration(), register it under a name.
//
//   struct Tap final : forefeel::Device {                    // into the body and back, `rate` times a second
//     double rate; forefeel::Vec3 deepest;
//     Tap(double r, const forefeel::Vec3& d) : rate(r), deepest(d) {}
//     forefeel::Vec3 position(double t, const forefeel::Vec3&) noexcept override {
//       return (0.5 - 0.5 * std::cos(6.2832 * rate * t)) * deepest;
//     }
//     double duration() const override { return std::numeric_limits<double>::infinity(); }
//   };
//   const bool known = (forefeel::register_device("tap", [](forefeel::FactoryContext& with) {
//     return std::make_unique<Tap>(with.arguments.number("rate", 1, 0.01, 20), 0.01 * with.inward); }), true);
//
// Scenes, studies and --device then know it as "tap" and "tap:rate=2".
//
// Order of calls. The factory and limits() run before the session. A device that does not answer the force is then asked
// for its whole motion, to check it; then it is asked frame by frame from t = 0 again. A device that answers the force is
// asked in this order too, with force zero in the check.
// Thread: the real-time loop under the real clock (1 kHz), the session's thread under the virtual clock; never two at once.
// Forbidden in position(): memory allocation, locks, exceptions, files, waiting. Under the virtual clock the position must
// be a function of t, the forces so far and the seed, so that a run repeats bit by bit.

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/device_spec.hpp"

namespace forefeel {

struct DeviceLimits {
  double force = std::numeric_limits<double>::infinity();      // the session's force never exceeds it [N]
  double stiffness = std::numeric_limits<double>::infinity();  // highest that it renders [N/m]
};

class Device {
 public:
  virtual ~Device() = default;
  // Position of the HIP at frame time t [s] from rest [m]; force is what was rendered in the last frame [N]. The motion
  // starts at rest, 0. A time before the last one starts the motion anew.
  virtual Vec3 position(double t, const Vec3& force) noexcept = 0;
  virtual double duration() const = 0;  // of the motion [s]; infinite for a motion without end
  // Whether the motion depends on the force; the policy clairvoyant, which needs the motion beforehand, then cannot run.
  virtual bool answers_force() const { return false; }
  virtual DeviceLimits limits() const { return {}; }
};

using DeviceFactory = std::function<std::unique_ptr<Device>(FactoryContext&)>;
// From any thread and also before main() begins. InputError for a name that is taken, those of built-in devices included.
void register_device(const std::string& name, DeviceFactory factory);
std::vector<std::string> registered_devices();  // sorted, without the built-in ones

// InputError for a value outside its range, a trace that cannot be read, a name that nobody registered.
std::unique_ptr<Device> make_device(const DeviceSpec& device, const FactoryContext& context);

// "path:NAME, trace:FILE or hand:PROFILE", and the registered ones: what is expected where a kind is unknown.
std::string device_kinds();

}  // namespace forefeel
