#pragma once
// Simulated haptic devices: where the HIP is at time t, and (for a hand) how it answers the force.
//   path:NAME[,speed=0.06][,amplitude=A][,tremor=S][,noise=S]
//     NAME: press line circle lissajous reach palpation tour mower. A path is a curve scaled to the box (or so that
//     its farthest point is A [m] from rest), run at `speed` [m/s] with rounded corners, where it is slower, as a
//     hand is; it starts at rest, x(0) = 0, and repeats for ever.
//   trace:FILE[,scale=F][,offset=X/Y/Z]
//     rows t,x,y,z; x(t) = F row + offset by cubic interpolation, held after the end.
//   hand:PROFILE[,target=NAME][,grip=K][,speed=0.06][,amplitude=A][,tremor=S][,noise=S]
//     PROFILE: touch premium omega falcon. A hand that follows path NAME (default press) through a grip of stiffness K
//     [N/m], or light (100), medium (300, the default) or firm (800), and yields to the force: hand_device.hpp.
// tremor [m RMS per axis, 8 to 12 Hz] and noise [m RMS per axis, white] are seeded.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct DeviceLimits {
  double force = std::numeric_limits<double>::infinity();      // [N]
  double stiffness = std::numeric_limits<double>::infinity();  // highest that it renders [N/m]
};

class Device {
 public:
  virtual ~Device() = default;
  // HIP position at frame time t [s]; force is what was rendered in the last frame. A time before the last one starts
  // the motion anew. Real-time: no allocation, no lock.
  virtual Vec3 position(double t, const Vec3& force) noexcept = 0;
  virtual double duration() const = 0;                  // [s]; infinite for endless paths
  virtual bool answers_force() const { return false; }  // whether the motion depends on the force
  virtual DeviceLimits limits() const { return {}; }
};

struct DeviceContext {
  Box box;                       // of the state space: paths are scaled to it
  Vec3 inward = -Vec3::UnitZ();  // from the contact into the body
  std::uint64_t seed = 0;
  std::filesystem::path folder;  // relative trace files are looked up here, then in the working directory
};

// spec as on the command line ("path:press,speed=0.06"). InputError on anything unknown.
std::unique_ptr<Device> make_device(const std::string& spec, const DeviceContext& context);
std::vector<std::string> path_names();

// A motion given by samples: times growing, the first 0 [s]; positions [m]. Also what --replay runs.
std::unique_ptr<Device> make_trace_device(std::vector<double> times, std::vector<Vec3> positions);
// t,x,y,z; the first time becomes 0. InputError(file:line) for short rows, what is not finite, time going back, no rows.
struct Trace {
  std::vector<double> times;    // [s]
  std::vector<Vec3> positions;  // [m]
};
Trace read_trace(const std::filesystem::path& file);

}  // namespace forefeel
