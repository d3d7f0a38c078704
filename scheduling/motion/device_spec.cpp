#include "scheduling/motion/device_spec.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

constexpr const char* paths[] = {"press",     "line", "circle", "lissajous", "reach",
                                 "palpation", "tour", "mower",  "raster"};
constexpr const char* hands[] = {"touch", "premium", "omega", "falcon"};

std::string setting(const char* key, double value) {
  return value == 0 ? "" : fmt::format(",{}={}", key, value);
}

std::string settings_of(const PathMotion& motion) {
  return (motion.speed ? fmt::format(",speed={}", *motion.speed) : "") +
         setting("amplitude", motion.amplitude) + setting("tremor", motion.tremor) +
         setting("noise", motion.noise) + setting("pause", motion.pause) +
         (motion.depth ? fmt::format(",depth={}", *motion.depth) : "") +
         (motion.where.empty() ? "" : ",where=" + motion.where);
}

std::string text_of(const PathMotion& motion) {
  return fmt::format("path:{}{}", name(motion.path), settings_of(motion));
}
std::string unit_of(const TraceFormat& format) {
  const char* length = format.metre == 1e-3 ? "mm" : format.metre == 1e-2 ? "cm" : "m";
  const char* time = format.second == 1e-3   ? "ms"
                     : format.second == 1e-6 ? "us"
                     : format.second == 1e-9 ? "ns"
                                             : "s";
  return format.metre == 1 && format.second == 1 ? "" : fmt::format(",unit={}/{}", length, time);
}
std::string text_of(const TraceFormat& format) {
  return (format.columns.empty() ? "" : fmt::format(",columns={}", fmt::join(format.columns, "/"))) +
         setting("rate", format.rate) + unit_of(format) +
         (format.tool.empty() ? "" : fmt::format(",tool={}", format.tool));
}
std::string text_of(const TraceMotion& motion) {
  const Vec3& o = motion.offset;
  const auto point = [](const char* key, const Vec3& p) {
    return fmt::format(",{}={}/{}/{}", key, p[0], p[1], p[2]);
  };
  return fmt::format("trace:{}{}{}{}{}", motion.file.string(), text_of(motion.format),
                     motion.scale == 1 ? "" : fmt::format(",scale={}", motion.scale),
                     o.isZero(0) ? "" : point("offset", o),
                     motion.placed ? point("register", *motion.placed) : "");
}
std::string changed(const char* key, double value, double usual) {
  return value == usual ? "" : fmt::format(",{}={}", key, value);
}
std::string text_of(const HandMotion& motion) {
  const HandTraits &t = motion.traits, usual;
  return fmt::format("hand:{},target={},grip={}{}", name(motion.profile), name(motion.target.path),
                     motion.grip, settings_of(motion.target)) +
         changed("mass", t.mass, usual.mass) + changed("zeta", t.damping_ratio, usual.damping_ratio) +
         changed("stiffening", t.stiffening, usual.stiffening) +
         changed("surprise", t.surprise, usual.surprise) + changed("delay", t.delay, usual.delay) +
         changed("calm", t.calm, usual.calm) + (t.drawn ? ",drawn=yes" : "");
}
std::string text_of(const Registered& device) {
  return to_text(device);
}

void expect_from(const InputPlace& where, const char* key, double value, double low) {
  if (!std::isfinite(value) || value < low)
    throw InputError(where, fmt::format("{} is '{}', expected a number of at least {}", key, value, low));
}
void expect_to(const InputPlace& where, const char* key, double value, double most) {
  if (value > most)
    throw InputError(where, fmt::format("{} is {:g}, expected at most {:g} {}", key, value, most,
                                        key == std::string_view("speed")   ? "m/s"
                                        : key == std::string_view("pause") ? "s"
                                                                           : "m"));
}

void check_motion(const InputPlace& where, const PathMotion& motion) {
  const double speed = motion.speed.value_or(usual_speed);
  expect_from(where, "speed", speed, 1e-6);
  if (motion.amplitude != 0) expect_from(where, "amplitude", motion.amplitude, 1e-6);
  expect_from(where, "tremor", motion.tremor, 0);
  expect_from(where, "noise", motion.noise, 0);
  expect_from(where, "pause", motion.pause, 0);
  if (motion.depth)
    expect_from(where, "depth", *motion.depth, 1e-6), expect_to(where, "depth", *motion.depth, 1);
  expect_to(where, "speed", speed, 1000);
  expect_to(where, "amplitude", motion.amplitude, 10);
  expect_to(where, "tremor", motion.tremor, 1);
  expect_to(where, "noise", motion.noise, 1);
  expect_to(where, "pause", motion.pause, 60);
}
void check_motion(const InputPlace& where, const TraceMotion& motion) {
  expect_from(where, "scale", motion.scale, -1e9);
  if (motion.format.rate != 0) {
    expect_from(where, "rate", motion.format.rate, 1e-3);
    if (motion.format.rate > 1e6)
      throw InputError(where, fmt::format("rate is {:g}, expected at most 1e6 Hz", motion.format.rate));
  }
  if (!motion.offset.allFinite())
    throw InputError(where, "offset is not X/Y/Z, expected three finite numbers [m]");
}
void check_motion(const InputPlace& where, const HandMotion& motion) {
  expect_from(where, "grip", motion.grip, 1);
  const HandTraits& traits = motion.traits;
  expect_from(where, "mass", traits.mass, 1e-3);
  expect_from(where, "zeta", traits.damping_ratio, 0);
  if (!(traits.damping_ratio < 1))
    throw InputError(where,
                     fmt::format("zeta is {:g}, expected a damping ratio below 1", traits.damping_ratio));
  expect_from(where, "stiffening", traits.stiffening, 0);
  expect_from(where, "surprise", traits.surprise, 1e-3);
  expect_from(where, "delay", traits.delay, 0);
  expect_from(where, "calm", traits.calm, 1e-3);
  check_motion(where, motion.target);
}
void check_motion(const InputPlace&, const Registered&) {}

}  // namespace

const char* name(PathName path) {
  return paths[static_cast<int>(path)];
}
const char* name(HandName hand) {
  return hands[static_cast<int>(hand)];
}
std::vector<std::string> path_names() {
  return {std::begin(paths), std::end(paths)};
}
std::vector<std::string> hand_names() {
  return {std::begin(hands), std::end(hands)};
}

std::string to_text(const DeviceSpec& device) {
  if (!device.written_.empty()) return device.written_;
  return std::visit([](const auto& motion) { return text_of(motion); }, device.motion_);
}

void check(const DeviceSpec& device) {
  const InputPlace where{.key = "device", .value = to_text(device)};
  std::visit([&](const auto& motion) { check_motion(where, motion); }, device.motion());
}

}  // namespace forefeel
