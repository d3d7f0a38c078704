#pragma once
// The device of a session, as a typed choice. The command parses the user's text for it
// ("path:press,speed=0.06"); to_text() returns that text.
//
//   options.motion.device = PathMotion{.path = PathName::circle, .speed = 0.1};
//   options.motion.device = HandMotion{.profile = HandName::omega, .grip = 800};
//   options.motion.device = Registered("mine", {{"gain", "2"}});   // registered with register_device()

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/common/arguments.hpp"
#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {

enum class PathName { press, line, circle, lissajous, reach, palpation, tour, mower, raster };
enum class HandName { touch, premium, omega, falcon };
const char* name(PathName path);
const char* name(HandName hand);
std::vector<std::string> path_names();          // in the order of the enumeration
std::string_view path_in_words(PathName path);  // "straight in …, and out"
std::vector<std::string> hand_names();

constexpr double usual_speed = 0.06;  // [m/s]

// A closed curve, repeated without end (path_shapes.hpp).
struct PathMotion {
  PathName path = PathName::press;
  std::optional<double> speed = {};  // [m/s], 1e-6 to 1000; unset: usual_speed
  double amplitude = 0;  // distance of the farthest point from rest [m], at most 10; 0: fits the box
  double tremor = 0;     // RMS per axis, 8 to 12 Hz [m], at most 1
  double noise = 0;      // RMS per axis, white [m], at most 1
  double pause = 0;      // at rest at each turn of more than 45 degrees [s], at most 60
  // On a body that may be touched anywhere (surface_shapes.hpp):
  std::optional<double> depth = {};  // [m]; unset: 0.6 of the depth of the states
  std::string where = {};            // part of the surface: x/y/z/radius or a node group; empty: all
};

// A recorded motion, samples of a file: position = scale * sample + offset (trace.hpp, trace_file.hpp).
struct TraceMotion {
  std::filesystem::path file;  // relative: to the scene's folder, else to the working directory
  double scale = 1;
  Vec3 offset = Vec3::Zero();  // [m]
  TraceFormat format = {};     // where in the file the samples are
  // On a body that may be touched anywhere: the first sample lies at the place of the surface nearest to this [m], and
  // the motion's z axis along the normal there.
  std::optional<Vec3> placed = {};
};

// Properties that differ between hands, besides the stiffness of the grip (hand_device.hpp).
struct HandTraits {
  double mass = 0.1;           // of hand and device [kg]
  double damping_ratio = 0.7;  // zeta [1]
  // Reaction to a surprise: a force that changes by more than `surprise` beyond what the last 0.1 s explain. After
  // `delay` the stiffness of the grip is multiplied by 1 + stiffening; this decays within `calm`.
  double stiffening = 0;  // 0: no reaction [1]
  double surprise = 0.5;  // [N]
  double delay = 0.1;     // [s]
  double calm = 0.5;      // [s]
  bool drawn = false;     // grip, mass, damping, tremor and reaction are drawn from the seed of the session
};

// A hand that holds a device and yields to the force while it follows a path (hand_device.hpp).
struct HandMotion {
  HandName profile = HandName::touch;
  PathMotion target = {};
  double grip = 300;  // stiffness [N/m], at least 1
  HandTraits traits = {};
};

class DeviceSpec {
 public:
  using Motion = std::variant<PathMotion, TraceMotion, HandMotion, Registered>;

  DeviceSpec() : DeviceSpec(PathMotion{.speed = usual_speed}) {}
  DeviceSpec(PathMotion motion) : motion_(std::move(motion)) {}
  DeviceSpec(TraceMotion motion) : motion_(std::move(motion)) {}
  DeviceSpec(HandMotion motion) : motion_(std::move(motion)) {}
  DeviceSpec(Registered device) : motion_(std::move(device)) {}
  // `written` is the user's text; to_text() returns it unchanged.
  DeviceSpec(Motion motion, std::string written) : motion_(std::move(motion)), written_(std::move(written)) {}

  const Motion& motion() const { return motion_; }
  friend std::string to_text(const DeviceSpec& device);

 private:
  Motion motion_;
  std::string written_;
};

std::string to_text(const DeviceSpec& device);
// InputError("device TEXT: …") for a value outside its range. Does not check files or registered names.
void check(const DeviceSpec& device);

}  // namespace forefeel
