// What came into a run is recorded, and renders again to the same bits: of both clocks, of runs that were cut, and not
// where the record was changed.

#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include "allocation_count.hpp"
#include "run_logs.hpp"
#include "scheduling/render/input_format.hpp"
#include "scheduling/render/input_log.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/input_replay.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

namespace {

SessionResult recorded(const fs::path& file, SessionInput input, const SessionOptions& options,
                       const SessionHooks& hooks = {}) {
  return run_session(with_inputs_file(make_plan(std::move(input), options), file, "test"), hooks);
}

SessionOptions real_options(double seconds) {
  SessionOptions options = virtual_options(seconds);
  options.clock.kind = Clock::real;
  options.motion.device = PathMotion{.path = PathName::tour, .speed = 0.06, .tremor = 1e-4};
  return options;
}

std::vector<InputRecord> records_of(const fs::path& file) {
  std::vector<InputRecord> all;
  InputReader reader(file);
  while (std::optional<InputRecord> record = reader.next()) all.push_back(*std::move(record));
  return all;
}

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

// The record holds the forces of the run itself, and their replay has the same bits.
void check_replay(const fs::path& file, const SessionResult& result) {
  std::vector<FrameInput> frames;
  for (const InputRecord& record : records_of(file)) {
    if (record.kind != InputKind::frame) continue;
    Unpacker content(record.content);
    frames.push_back(unpack_frame(content));
  }
  REQUIRE(frames.size() == result.frames.size());
  std::size_t same = 0;
  for (std::size_t k = 0; k < frames.size(); ++k)
    same += same_bits(frames[k].rendered, result.frames[k].force) &&
            same_bits(frames[k].sent, result.frames[k].sent) && same_bits(frames[k].at, result.frames[k].at);
  CHECK(same == frames.size());

  const ReplayReport report = replay_inputs(file, "test");
  const std::size_t first_difference = report.first ? report.first->frame : 0;
  CAPTURE(first_difference);
  CHECK(report.frames == result.frames.size());
  CHECK(report.equal == report.frames);
  CHECK_FALSE(report.first);
  CHECK(report.whole);
  CHECK(report.states == result.states.size());
  CHECK(report.failed == result.counts.failed);
  CHECK(report.made_by == report.replayed_by);
  CHECK(report.bytes == fs::file_size(file));
}

std::string refusal(const fs::path& file) {
  return error_of([&] { replay_inputs(file); });
}

void write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("a real run, its workers and its wall time, replays to the same bits") {
  const TemporaryFolder folder;
  SessionInput input = small_input();
  SessionOptions options = real_options(1.2);
  SECTION("elastic, models in another order than states") {
    options.workers.count = 2;
  }
  SECTION("viscous") {
    input.touched.viscosity = {{0.3, 0.03}, {0.2, 0.4}};
  }
  SECTION("rule paper, force alone, interpolation") {
    options.switching.rule = SwitchRule::paper;
    options.model.method = SessionMethod::tricubic;
  }
  SECTION("a first guess") {
    input = test::block_input();
  }
  const SessionResult result = recorded(folder / "inputs", input, options);
  CHECK(result.failures.empty());
  REQUIRE(result.counts.solved > 5);
  check_replay(folder / "inputs", result);
}

TEST_CASE("virtual runs replay to the same bits, and recording changes none of theirs") {
  const TemporaryFolder folder;
  SessionOptions options = virtual_options(2.5);
  const PathMotion press{.path = PathName::press, .speed = 0.06};
  for (const bool controlled : {false, true}) {
    for (const bool hand : {false, true}) {
      CAPTURE(hand, controlled);
      if (controlled) options.safety.passivity = Passivity::control;
      if (hand) options.motion.device = DeviceSpec(HandMotion{.profile = HandName::omega, .target = press});
      const SessionResult plain = run_session(small_input(), options);
      const SessionResult result = recorded(folder / "inputs", small_input(), options);
      REQUIRE(result.frames.size() == plain.frames.size());
      std::size_t same = 0;
      for (std::size_t k = 0; k < plain.frames.size(); ++k)
        same += same_bits(plain.frames[k].force, result.frames[k].force);
      CHECK(same == plain.frames.size());
      check_replay(folder / "inputs", result);
    }
  }
}

TEST_CASE("runs that are interrupted replay with their ramp to zero") {
  const TemporaryFolder folder;
  for (const Clock clock : {Clock::real, Clock::virtual_time}) {
    SessionOptions options = real_options(60);
    options.clock.kind = clock;
    std::atomic<bool> stop{false};
    options.stop.interrupted = &stop;
    const SessionResult result =
        recorded(folder / "inputs", small_input(), options, {.progress = [&](const SessionProgress& p) {
                   stop = stop || (p.phase == SessionPhase::session && p.t > 0.5);
                 }});
    CHECK(result.interrupted());
    REQUIRE(result.frames.size() < 30000);
    check_replay(folder / "inputs", result);
  }
}

TEST_CASE("a record that was cut replays as far as it goes; a changed or damaged one does not") {
  const TemporaryFolder folder;
  const fs::path file = folder / "inputs", other = folder / "other";
  const SessionResult result = recorded(file, small_input(), virtual_options(0.6));
  const std::string bytes = text_of(file);
  const std::vector<InputRecord> records = records_of(file);
  const InputRecord& last = records.back();
  REQUIRE(last.kind == InputKind::frame);

  for (const std::size_t left : {last.at, last.at + 1, last.at + 4, last.at + 5, last.at + 60}) {
    write(other, bytes.substr(0, left));
    const ReplayReport report = replay_inputs(other);
    CHECK_FALSE(report.whole);
    CHECK(report.frames == 599);
    CHECK(report.equal == 599);
  }

  // One bit of one force: of a state, of a frame.
  std::size_t states = 0;
  for (const InputRecord& record : records) {
    const bool state = record.kind == InputKind::state && ++states == 2;
    if (!state && record.at != last.at) continue;
    std::string changed = bytes;
    // kind and length, then: status, position, force; or number, known, model, flags, three times, position, force
    changed[record.at + 5 + (state ? 1 + 24 : 17 + 24 + 24)] ^= 1;
    write(other, changed);
    const ReplayReport report = replay_inputs(other);
    CHECK(report.frames == 600);
    CHECK(report.equal < 600);
    REQUIRE(report.first);
    CHECK_FALSE(report.first->sent);
    if (!state) CHECK(report.first->frame == 599);
    if (!state) CHECK(report.equal == 599);
  }

  const auto damaged = [&](std::size_t at, char byte) {
    std::string changed = bytes;
    changed.at(at) = byte;
    write(other, changed);
    return refusal(other);
  };
  const std::string place = other.string() + ": is damaged at byte ";
  CHECK_THAT(damaged(last.at, 'Q'), Catch::StartsWith(place + std::to_string(last.at)));
  CHECK_THAT(damaged(last.at + 1, 7), Contains("no record of a run begins there"));
  CHECK_THAT(damaged(last.at + 5, 0), Contains("a frame that is not later than the one before"));
  CHECK_THAT(damaged(records[0].at - 20, '\x55'), Contains("the header is damaged"));
  CHECK_THAT(damaged(3, 'x'), Contains("is no record of a run"));
  write(other, bytes.substr(0, 30));
  CHECK_THAT(refusal(other), Contains("ends before the first frame"));
  write(other, bytes + "more");
  CHECK_THAT(refusal(other), Contains("bytes behind the end"));
  CHECK_THAT(refusal(folder / "none"), Contains("cannot be read"));
}

TEST_CASE("a full disk ends the record, not the run, and what was written replays") {
  const TemporaryFolder folder;
  const SessionOptions options = real_options(1);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
  rlimit little = before;
  little.rlim_cur = 70'000;  // about 0.5 s
  setrlimit(RLIMIT_FSIZE, &little);
  const SessionResult result = recorded(folder / "inputs", small_input(), options);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  CHECK(result.frames.size() + result.loop.skipped >= 1000);
  CHECK_FALSE(result.interrupted());
  REQUIRE(result.failures.size() == 1);
  CHECK_THAT(result.failures[0], Catch::StartsWith((folder / "inputs").string() + ": cannot be written: ") &&
                                     Catch::EndsWith("cannot be replayed"));
  const ReplayReport report = replay_inputs(folder / "inputs");
  CHECK_FALSE(report.whole);
  CHECK(report.frames > 100);
  CHECK(report.frames < result.frames.size());
  CHECK(report.equal == report.frames);
  CHECK_THAT(result.failures[0], Contains(fmt::format("frames after {:.3f} s cannot", report.seconds)));
}

TEST_CASE(
    "recording a frame allocates nothing; a disk that is too slow ends the record before the first lost "
    "frame") {
  const TemporaryFolder folder;
  const SessionInput input = small_input();
  const auto device = make_device(PathMotion{.path = PathName::tour},
                                  {.box = input.touched.space.box, .seed = 1, .folder = {}});
  const RenderOptions options;
  constexpr std::size_t frames = 10'000;
  InputLog log(folder / "inputs",
               {.made_by = "test", .frames = frames, .render = options, .space = input.touched.space}, false);
  LoopLink link;
  link.inputs = &log;
  RenderLoop loop(*device, link, options, frames);
  const std::size_t before = test::allocations();
  for (std::size_t k = 0; k < frames; ++k) loop.frame(k);  // nobody drains
  if (FOREFEEL_COUNTS_ALLOCATIONS) CHECK(test::allocations() == before);
  log.close();
  REQUIRE(log.failure());
  CHECK_THAT(*log.failure(), Contains("the disk was too slow; frames after 8.190 s"));
  const ReplayReport report = replay_inputs(folder / "inputs");
  CHECK(report.frames == 8191);
  CHECK(report.equal == 8191);
  CHECK_FALSE(report.whole);
}
