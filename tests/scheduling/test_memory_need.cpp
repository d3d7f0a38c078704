// A session that needs more memory than there is, is refused before it begins, in one line.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "geometry/common/error.hpp"
#include "scheduling/session/memory_need.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

using namespace forefeel;
using testing::small_input;
using testing::virtual_options;

namespace {

std::string refusal(const SessionPlan& plan, double available) {
  try {
    check_memory(plan, available);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a session that no memory holds is refused with what it would take, what there is, and what fits") {
  SessionPlan plan = make_plan(small_input(), virtual_options(1));
  const double small = memory_need(plan).all();
  CHECK(small > 1000 * sizeof(FrameRecord));
  CHECK(small < 1e7);
  CHECK(refusal(plan, 1e9).empty());
  plan.frames = 86'400'000;
  plan.options.clock.seconds = 86400;
  const std::string frames = refusal(plan, 4e9);
  CHECK_THAT(frames, Catch::StartsWith("session.seconds: is 86400, and 86400000 frames take about") &&
                         Catch::Contains("4 GB are free, expected at most"));
  // as many seconds as it says fit
  plan.options.clock.seconds = std::stod(frames.substr(frames.rfind(' ')));
  plan.frames = static_cast<std::size_t>(1000 * plan.options.clock.seconds);
  CHECK(plan.options.clock.seconds > 1000);
  CHECK(refusal(plan, 4e9).empty());
}

TEST_CASE("workers of the real clock are counted with their solvers, simulated ones take nothing") {
  SessionOptions options = virtual_options(1);
  options.workers.count = 3000;
  const SessionPlan simulated = make_plan(small_input(), options);
  CHECK(memory_need(simulated).workers == 0);
  options.workers.count = 2;
  options.clock.kind = Clock::real;
  SessionPlan real = make_plan(small_input(), options);
  real.options.workers.count = 3000;
  const MemoryNeed need = memory_need(real);
  CHECK(need.workers > 3000 * 256e3);
  CHECK(need.workers < 3000 * 10e6);
  CHECK_THAT(refusal(real, 1e8), Catch::StartsWith("session.workers: is 3000"));
  CHECK(refusal(real, 1e12).empty());
  real.options.workers.count = 100'000;
  CHECK_THAT(refusal(real, 1e15), Catch::Contains("each worker is a thread, expected at most 4096"));
  // threads of reference solves are as many as have a use
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  CHECK(reference_threads(4096) <= std::max(8, 4 * cores));
  CHECK(reference_threads(3) == 3);
  CHECK(reference_threads(0) >= 1);
}
