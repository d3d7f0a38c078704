// A disk that becomes full during a session: all other files are written, and the failure is reported.

#include <signal.h>
#include <sys/resource.h>

#include "geometry/states/state_file.hpp"
#include "run_logs.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

// No file of this process may grow while an object lives: each write fails as on a full disk (EFBIG).
class FullDisk {
 public:
  FullDisk() : handler_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit none = before_;
    none.rlim_cur = 0;
    setrlimit(RLIMIT_FSIZE, &none);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("a full disk of the states' file costs later states their place in it, and nothing else") {
  for (const Clock clock : {Clock::virtual_time, Clock::real}) {
    CAPTURE(static_cast<int>(clock));
    const TemporaryFolder folder;
    SessionInput input = small_input();
    input.files.states = folder / "session.states";
    if (clock == Clock::real) input.touched.space.spacing = 0.0015;  // more states than it can solve
    SessionOptions options = virtual_options(clock == Clock::real ? 3 : 0.6);
    options.clock.kind = clock;
    std::unique_ptr<FullDisk> full;
    const SessionResult result = run_session(input, options, {.progress = [&](const SessionProgress& p) {
                                               if (!full && p.phase == SessionPhase::session && p.t > 0.05)
                                                 full = std::make_unique<FullDisk>();
                                             }});
    REQUIRE(full);
    full.reset();
    CHECK_FALSE(result.interrupted());
    CHECK(result.frames.size() + result.loop.skipped >= (clock == Clock::real ? 3000 : 600));
    REQUIRE(result.failures.size() == 1);
    CHECK_THAT(result.failures[0], Catch::StartsWith((folder / "session.states").string() + ": cannot be") &&
                                       Contains("are not in this file"));
    const auto kept = StateFile::open_read_only(*input.files.states).read_all();
    CHECK(kept.size() < result.states.size());
    CHECK(summarise(result, input, options).run.failures == result.failures);
    // the tables of the run are whole
    prepare_run_folder(folder / "run");
    write_run_files(folder / "run", result, options);
    const std::string frames = text_of(folder / "run" / "frames.csv");
    CHECK(static_cast<std::size_t>(std::ranges::count(frames, '\n')) == result.frames.size() + 1);
  }
}

TEST_CASE("a full disk of the cache is a warning only, and the results are the same") {
  const TemporaryFolder folder;
  SessionInput input = small_input();
  const SessionOptions options = virtual_options(0.4);
  const SessionResult without = run_session(input, options);
  input.files.cache = folder / "cache";
  input.references = std::make_shared<ReferenceService>(reference_options(input), 1);
  REQUIRE_FALSE(input.references->note());
  SessionResult result;
  {
    const FullDisk full;
    result = run_session(input, options);
  }
  CHECK(result.failures.empty());
  CHECK_FALSE(result.interrupted());
  REQUIRE(result.warnings.size() == 1);
  CHECK_THAT(result.warnings[0], Contains("cache of reference solves is no longer written"));
  REQUIRE(result.frames.size() == without.frames.size());
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    REQUIRE(result.frames[k].force == without.frames[k].force);
    REQUIRE((result.frames[k].judged.error == without.frames[k].judged.error ||
             !result.frames[k].judged.sampled));
  }
}

TEST_CASE("tables that can be written are, and the error names those that cannot") {
  const TemporaryFolder folder;
  const SessionOptions options = virtual_options(0.1);
  const SessionResult result = run_session(small_input(), options);
  prepare_run_folder(folder / "run");
  fs::create_directories(folder / "run" / "switches.csv" / "in the way");
  CHECK_THAT(error_of([&] { write_run_files(folder / "run", result, options); }),
             Contains("is incomplete", "switches.csv") && !Contains("frames.csv"));
  CHECK(fs::is_regular_file(folder / "run" / "frames.csv"));
  CHECK(fs::is_regular_file(folder / "run" / "dispatch.csv"));
}
