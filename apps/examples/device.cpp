// A device of your own that follows a measured motion. Usage: device MOTION.csv, columns t,x,y,z [s, m].

#include <fmt/format.h>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

// 1. A device returns the position of the hand at time t, once a millisecond. It must not allocate, lock or throw.
struct Measured final : Device {
  std::vector<std::pair<double, Vec3>> samples;
  double duration() const override { return samples.back().first; }
  Vec3 position(double t, const Vec3&) noexcept override {  // interpolated between two samples [m]
    const auto b = std::ranges::upper_bound(samples, t, {}, &std::pair<double, Vec3>::first);
    if (b == samples.begin() || b == samples.end()) return (b == samples.end() ? samples.back() : *b).second;
    const auto a = std::prev(b);
    return a->second + (t - a->first) / (b->first - a->first) * (b->second - a->second);
  }
};

int main(int argc, char** argv) try {
  // 2. The motion, read before the session begins; a bad file is one clear error line.
  if (argc < 2) return fmt::print(stderr, "usage: device MOTION.csv\n"), 2;
  auto device = std::make_shared<Measured>();
  const Trace motion = read_trace(argv[1]);
  for (std::size_t i = 0; i < motion.times.size(); ++i)
    device->samples.emplace_back(motion.times[i], motion.positions[i]);
  // 3. The session takes the device as an object.
  auto body = std::make_shared<Body>();
  body->mesh = phantom("beam", 240);
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  SessionInput input{.touched = {.body = body, .space = {.spacing = 0.004}}, .parts = {.device = device}};
  input.touched.space.box = {Vec3::Constant(-0.012), Vec3::Constant(0.012)};  // of the states [m]
  SessionOptions options;
  options.clock = {.kind = Clock::virtual_time, .seconds = device->duration()};
  for (const FrameRecord& frame : run_session(input, options).frames)
    fmt::print("{:.3f},{:.6f}\n", frame.t, frame.sent.norm());  // [s], [N]
} catch (const InputError& error) {
  return fmt::print(stderr, "{}\n", error.what()), 2;
}
