// A session that needs more memory than there is, is refused before it begins, in one line.

#include "scheduling/session/memory_need.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

std::string refusal(const MemoryRequest& asked, double available) {
  return error_of([&] { check_memory(asked, available); });
}

MemoryRequest one_second() {
  return {.body = test::small_body(), .frames = 1000, .seconds = 1, .workers = 2, .threads = 1};
}

}  // namespace

TEST_CASE("a session that no memory holds is refused with what it would take, what there is, and what fits") {
  MemoryRequest asked = one_second();
  CHECK(memory_need(asked).all() > 1000 * sizeof(FrameRecord));
  CHECK(memory_need(asked).all() < 1e7);
  CHECK(refusal(asked, 1e9).empty());
  asked.frames = 86'400'000;
  asked.seconds = 86400;
  const std::string frames = refusal(asked, 4e9);
  CHECK_THAT(frames, Catch::StartsWith("session.seconds: is 86400, and 86400000 frames take about") &&
                         Contains("4 GB are free, expected at most"));
  // as many seconds as it says fit
  asked.seconds = std::stod(frames.substr(frames.rfind(' ')));
  asked.frames = static_cast<std::size_t>(1000 * asked.seconds);
  CHECK(asked.seconds > 1000);
  CHECK(refusal(asked, 4e9).empty());
}

TEST_CASE(
    "workers of the real clock are counted with their solvers, and no more threads than a process has") {
  MemoryRequest asked = one_second();
  asked.workers = 3000;
  CHECK(memory_need(asked).workers > 3000 * 256e3);
  CHECK(memory_need(asked).workers < 3000 * 10e6);
  CHECK_THAT(refusal(asked, 1e8), Catch::StartsWith("session.workers: is 3000"));
  CHECK(refusal(asked, 1e12).empty());
  asked.workers = 100'000;
  CHECK_THAT(refusal(asked, 1e15), Contains("each worker is a thread, expected at most 4096"));
  // simulated workers are no threads
  SessionOptions options = virtual_options(0.1);
  options.workers.count = 100'000;
  CHECK_NOTHROW(make_plan(small_input(), options));
  options.clock.kind = Clock::real;
  CHECK_THROWS_AS(make_plan(small_input(), options), InputError);
  // threads of reference solves are as many as have a use
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  CHECK(reference_threads(4096) <= std::max(8, 4 * cores));
  CHECK(reference_threads(3) == 3);
  CHECK(reference_threads(0) >= 1);
}
