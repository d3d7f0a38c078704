// A haptic session in code: a simulated hand, workers that solve ahead of it, and the summary as a type.

#include <fmt/format.h>
#include <forefeel/forefeel.hpp>

using namespace forefeel;

int main() {
  // 1. What is touched, and where states may be placed.
  auto body = std::make_shared<Body>();
  body->mesh = phantom("beam", 240);
  body->material = {.law = Law::neo_hookean, .young = 5000, .poisson = 0.3};
  body->clamp = body->mesh.groups.at("clamp");
  body->contact = body->mesh.groups.at("contact");
  const Box reach{Vec3::Constant(-0.012), Vec3::Constant(0.012)};
  const SessionInput input{.touched = {.body = body, .space = {.spacing = 0.004, .box = reach}}};

  // 2. The motion of the hand, the workers and the clock. Runs under the virtual clock repeat on every machine.
  SessionOptions options;
  options.clock = {.kind = Clock::virtual_time, .seconds = 2};
  options.motion.device = PathMotion{.path = PathName::circle, .speed = 0.04};  // [m/s]
  options.workers.count = 3;
  options.workers.cost = ConstantCost{.seconds = 0.3};  // of a simulated solve: the hand gets ahead of it
  options.model.fit = {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};

  // 3. The run. Its result holds every frame; the summary holds the statistics.
  const SessionPlan plan = make_plan(input, options);
  const SessionResult result = run_session(plan);
  const SessionSummary summary = summarise(result, plan);
  fmt::print("frames {}, states solved {}\n", summary.run.frames, summary.states.solved);
  fmt::print("in safe places {:.0f} % of the time\n", 100 * summary.time_in[Label::safe]);
  fmt::print("error below what a hand can tell: {:.0f} % of the path\n",
             100 * summary.error.samples.within_jnd);
  fmt::print("frames whose force was clamped: {}\n", summary.safety.clamped);
}
