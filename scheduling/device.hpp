#pragma once
// Simulated haptic devices: where the HIP is at time t, and (for a hand) how it answers the force.
//   path:NAME[,speed=0.06][,amplitude=…][,tremor=…][,noise=…]   NAME: press line circle lissajous reach palpation
//   trace:FILE[,scale=…][,offset=x/y/z]
// tremor [m RMS, 8 to 12 Hz] and noise [m RMS, white] are seeded.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "geometry/types.hpp"

namespace forefeel {

class Device {
 public:
  virtual ~Device() = default;
  // HIP position at frame time t [s]; force is what was rendered in the last frame. Real-time: no allocation, no lock.
  virtual Vec3 position(double t, const Vec3& force) noexcept = 0;
  virtual double duration() const = 0;     // [s]; infinite for endless paths
};

struct DeviceContext {
  Box box;                          // of the state space: paths are scaled to it
  Vec3 inward = -Vec3::UnitZ();     // from the contact into the body
  std::uint64_t seed = 0;
  std::filesystem::path folder;     // relative trace files are looked up here, then in the working directory
};

// spec as on the command line ("path:press,speed=0.06"). InputError on anything unknown.
std::unique_ptr<Device> make_device(const std::string& spec, const DeviceContext& context);

}  // namespace forefeel
