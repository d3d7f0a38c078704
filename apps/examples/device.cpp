// A device of your own that follows a measured motion. Usage: device MOTION.csv, rows of t,x,y,z [s, m].

#include <fmt/format.h>

#include <forefeel/forefeel.hpp>
#include <fstream>

using namespace forefeel;

// 1. A device says where the hand is at time t, once a millisecond: it must not allocate, lock or throw.
struct Measured final : Device {
  std::vector<double> times;
  std::vector<Vec3> positions;
  double duration() const override { return times.back(); }
  Vec3 position(double t, const Vec3&) noexcept override {
    const auto next = static_cast<std::size_t>(std::ranges::upper_bound(times, t) - times.begin());
    if (next == 0 || next == times.size()) return next == 0 ? positions.front() : positions.back();
    const double share = (t - times[next - 1]) / (times[next] - times[next - 1]);
    return (1 - share) * positions[next - 1] + share * positions[next];
  }
};

int main(int argc, char** argv) {
  // 2. The motion, read before the session begins.
  auto device = std::make_shared<Measured>();
  std::ifstream file(argc > 1 ? argv[1] : "");
  double t, x, y, z;
  for (char comma; file >> t >> comma >> x >> comma >> y >> comma >> z;)
    device->times.push_back(t), device->positions.emplace_back(x, y, z);
  if (device->times.empty()) return fmt::print(stderr, "expected a file of t,x,y,z\n"), 2;

  // 3. The session takes the device as an object.
  const double spacing = 0.004;
  auto body = std::make_shared<Body>(Body{.mesh = phantom("beam", 240)});
  body->clamp = body->mesh.groups.at("clamp"), body->contact = body->mesh.groups.at("contact");
  const Box reach{Vec3::Constant(-3 * spacing), Vec3::Constant(3 * spacing)};
  SessionInput input{.touched = {.body = body, .space = {.spacing = spacing, .box = reach}}};
  input.parts.device = device;
  const SessionOptions options{.clock = {.kind = Clock::virtual_time, .seconds = device->duration()}};
  for (const FrameRecord& frame : run_session(input, options).frames)
    if (frame.t >= 0) fmt::print("{:.3f},{:.6f}\n", frame.t, frame.sent.norm());  // [s], [N]
}
