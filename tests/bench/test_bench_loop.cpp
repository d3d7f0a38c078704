// bench loop: the structure of its rows and the counting behind them; timings depend on the machine and are not
// asserted.

#include "apps/bench/bench_loop_parts.hpp"
#include "scheduling/render/bare_loop.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "tests/support/executable.hpp"

TEST_CASE("missed frames: skipped ones and those whose cost and lateness exceed a frame",
          "[bench_loop]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  std::vector<FrameRecord> records(2998);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::size_t k = i < 1500 ? i : i + 2;  // two frames were skipped
    records[i].t = 1e-3 * static_cast<double>(k);
    records[i].timing = {.cost_us = 5, .lateness_us = 50};
  }
  records[10].timing = {.cost_us = 600, .lateness_us = 401};
  const std::vector<FrameTiming> ours = timing_by_frame(records, 1e-3, 3000);
  REQUIRE(ours.size() == 3000);
  CHECK(std::isnan(ours[1500].cost_us));
  CHECK(std::isnan(ours[1501].cost_us));
  CHECK(ours[2999].cost_us == 5);
  LoopTimes loop, bare;
  loop.add(ours, 1e-3);
  bare.add(std::vector<FrameTiming>(3000, {.cost_us = 0, .lateness_us = 1}), 1e-3);
  CHECK(loop.frames == 3000);
  CHECK(loop.missed == 3);
  CHECK(loop.cost.size() == 2998);
  CHECK(loop.by_second == std::vector<std::vector<double>>{{1, 2, 0}});
  CHECK(bare.missed == 0);
  const ConfidenceInterval difference = missed_difference(loop, bare, 1e-3);
  CHECK(difference.mean == Approx(1));  // per 1000
  CHECK(difference.low >= 0);
  CHECK(difference.high <= 2);
  CHECK_FALSE(missed_difference(bare, bare, 1e-3).excludes_zero());
}

TEST_CASE("the course of memory: start, end and slope of the second half",
          "[bench_loop]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  MemoryCourse course;
  for (int i = 0; i <= 100; ++i) {
    course.t.push_back(0.1 * i);
    course.bytes.push_back(1e6 + (i < 50 ? 1e5 * i : 5e6 + 300 * (i - 50)));
  }
  CHECK(course.start() == 1e6 + 1e6);
  CHECK(course.end() == Approx(6e6 + 15000));
  CHECK(course.growth() == Approx(3000));
  CHECK(resident_memory() > 1e6);
}

TEST_CASE("a bare loop has a time for every frame that it did not skip, and may end before it begins",
          "[bench_loop]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  BareLoop loop(1e-3, 50);
  CHECK_FALSE(loop.begun());
  loop.begin(monotonic() + 1000000);
  CHECK(loop.begun());
  sleep_until(monotonic() + 2000000000);  // 51 ms, and time for a loaded machine
  loop.end();
  REQUIRE(loop.frames().size() == 50);
  CHECK(std::isfinite(loop.frames().back().lateness_us));  // the last frame is never skipped
  for (const FrameTiming& frame : loop.frames())
    if (!std::isnan(frame.cost_us)) CHECK(frame.lateness_us >= 0);
  BareLoop never(1e-3, 50);
  never.end();
  CHECK(never.frames().empty());
}

TEST_CASE("bench loop compares the session's loop with a bare one, with and without the record",
          "[bench_loop]" SLOW("runs forefeel-bench, which only run.sh all builds")) {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome outcome =
      shop.forefeel_bench("loop beam.toml --seconds 4 --blocks 2 --states 60 --json");
  INFO(outcome.err);
  const json found = outcome.json();
  const auto& rows = found["rows"];
  REQUIRE(rows.size() == 3);
  for (const auto& row : rows)
    for (const char* key : {"name", "baseline", "ratio", "ours_us", "baseline_us", "error", "n", "k", "scene",
                            "law", "elements", "threads", "tolerance"})
      CHECK(row.contains(key));
  bool good = true;
  for (int i = 0; i < 2; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    CHECK(row["record"] == (i == 1));
    CHECK(row["baseline"] == "bare loop");
    const std::size_t frames = row["loop"]["frames"];
    CHECK(frames == row["bare"]["frames"].get<std::size_t>());
    CHECK(frames <= 4000);
    CHECK(row["seconds"].get<double>() == Approx(1e-3 * static_cast<double>(frames)));
    CHECK(row["loop"]["missed"].get<std::size_t>() <= frames);
    CHECK(row["states"]["start"].get<int>() > 20);
    CHECK(row["states"]["start"].get<int>() <= 60);
    CHECK(row["error"]["p95"].get<double>() < 1);
    CHECK(row["memory"]["end"].get<double>() > 1e6);
    const auto& difference = row["missed_difference"];
    const double low = difference["low"], high = difference["high"];
    CHECK(low <= high);
    CHECK(difference["within_noise"].get<bool>() == (low <= 0 && high >= 0));
    good = good && low <= 0 && row["loop"]["cost_us"]["p99"].get<double>() < 10;
  }
  CHECK(rows[2]["baseline_us"] == rows[0]["loop"]["cost_us"]["p50"]);
  CHECK(rows[2]["ours_us"] == rows[1]["loop"]["cost_us"]["p50"]);
  CHECK(found["good"] == good);
  CHECK(outcome.code == (good ? 0 : 1));
}
