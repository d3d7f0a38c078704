// forefeel-bench loop [SCENE]: the 1 kHz loop of a session beside a bare loop that only waits for its deadlines.
// Both run at the same time in one process, half a frame apart, with the same thread settings, so that they meet the
// same load: the session's workers, and as many threads of tight solves that take every processor the workers leave
// idle. Runs with and without the recording of inputs (session.record) alternate.
//   missed      frames that were skipped, or whose cost and lateness together exceed their length
//   difference  missed of the loop less missed of the bare loop, per 1000 frames, with an interval of 95 % by a
//               bootstrap over seconds; within noise if it contains zero
//   lateness    of the wake-up [us];  cost: of the frame's work [us]
//   error       of the rendered force against tight solves, relative, as in a session
//   memory      resident memory of the process [bytes]; growth over the second half of the runs [bytes/s]
// Frames allocate nothing; a test counts allocations (tests/scheduling/test_render_loop.cpp).

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stop_token>
#include <thread>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_loop_parts.hpp"
#include "apps/bench/bench_row.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene/laboratory.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/render/bare_loop.hpp"
#include "scheduling/render/loop_thread.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr double most_cost = 10;         // of a frame, p99 [us]
constexpr double reference_step = 0.01;  // travel between samples of the error [m]

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

// Threads of tight solves at random places of the box. They take only processors that nothing else of this machine
// wants.
class Load {
 public:
  Load(const Scene& scene, int threads, std::uint64_t seed) {
    for (int i = 0; i < threads; ++i)
      threads_.emplace_back([this, &scene, key = random::mix(seed, static_cast<std::uint64_t>(i))](
                                const std::stop_token& stop) { run(scene, key, stop); });
  }
  std::size_t solves() const { return solves_.load(); }

 private:
  void run(const Scene& scene, std::uint64_t key, const std::stop_token& stop) {
    become_idle_thread();
    Solver solver(scene.body);
    const Box& box = scene.space.box;
    for (std::uint64_t i = 0; !stop.stop_requested(); ++i) {
      Vec3 x = box.low;
      for (int axis = 0; axis < 3; ++axis)
        x[axis] +=
            box.size()[axis] * random::uniform(random::mix(key, 3 * i + static_cast<std::uint64_t>(axis)));
      solver.from(*solver.rest(), x, {}, stop);
      ++solves_;
    }
  }

  std::atomic<std::size_t> solves_{0};
  std::vector<std::jthread> threads_;  // last: they end before the counter does
};

// A folder for the records, removed at the end.
class Scratch {
 public:
  Scratch() : folder_(fs::temp_directory_path() / fmt::format("forefeel-bench-loop-{}", getpid())) {
    fs::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return folder_; }

 private:
  fs::path folder_;
};

// All runs of one kind: with or without the record.
struct Kind {
  bool record = false;
  LoopTimes loop = {}, bare = {};
  std::vector<double> errors = {};
  double seconds = 0, cpu = 0, busy = 0;  // of the runs; of the process; of the workers' solves [s]
  std::size_t load_solves = 0, states_start = 0, states_end = 0;
  bool realtime = true;
  std::vector<MemoryCourse> memory = {};
};

struct Setting {
  const Scene& scene;
  SessionInput input;
  SessionOptions options;
  fs::path folder;
};

// The run of both loops. They are compared from the first moment at which the session shows its progress.
void run_block(const Setting& setting, Kind& kind, const ShowShare& show) {
  SessionOptions options = setting.options;
  options.record = kind.record;
  SessionPlan plan = make_plan(setting.input, options);
  plan = with_inputs_file(std::move(plan), setting.folder / "inputs.bin", program_text());
  const double frame = options.clock.frame;
  BareLoop bare(frame, plan.frames);
  std::size_t first = 0;  // frame of the session half a frame before the bare loop's first
  MemoryCourse memory;
  double cpu = 0;
  auto load = std::make_unique<Load>(setting.scene, options.workers.count, options.seed);
  const auto watch = [&](const SessionProgress& p) {
    if (p.phase != SessionPhase::session) return;
    if (!bare.begun()) {
      cpu = cpu_seconds();
      first = static_cast<std::size_t>(p.t / frame) + 20;
      const double ahead = (static_cast<double>(first) + 0.5) * frame - p.t;
      bare.begin(monotonic() + std::llround(ahead * 1e9));
    }
    memory.t.push_back(p.t);
    memory.bytes.push_back(resident_memory());
    if (show) show(p.t / p.seconds, fmt::format("{} states", p.known));
  };
  const SessionResult result = run_session(plan, {.progress = watch, .when_run = [&](const SessionResult&) {
                                                    bare.end();
                                                    kind.cpu += cpu_seconds() - cpu;
                                                    kind.load_solves += load->solves();
                                                    load.reset();
                                                  }});
  bare.end();
  const std::vector<FrameTiming> ours = timing_by_frame(result.frames, frame, plan.frames);
  const std::size_t n =
      std::min(bare.frames().size(), plan.frames - std::min(plan.frames, first));  // of both
  kind.loop.add(std::span(ours).subspan(std::min(first, ours.size()), n), frame);
  kind.bare.add(std::span(bare.frames()).first(n), frame);
  for (const FrameRecord& f : result.frames)
    if (f.judged.sampled && std::isfinite(f.judged.error)) kind.errors.push_back(f.judged.error);
  for (const double solve : result.solver.seconds) kind.busy += solve;
  kind.seconds += static_cast<double>(n) * frame;
  kind.states_start = result.counts.start;
  kind.states_end = std::max(kind.states_end, result.states.size());
  kind.realtime = kind.realtime && result.run.realtime_priority && bare.note().empty();
  kind.memory.push_back(std::move(memory));
}

Json timing_json(const std::vector<double>& values) {
  return json_numbers({quantile_of(values, 0.5), quantile_of(values, 0.99), quantile_of(values, 1)});
}

JsonKeys<LoopTimes> side_keys(const std::string& frames_mean) {
  using L = LoopTimes;
  return {{"frames,missed", "", frames_mean,
           [](const L& l) {
             return Json::array({l.frames, l.missed});
           }},
          {"lateness_us.p50,p99,max", "us", "of its wake-ups",
           [](const L& l) { return timing_json(l.lateness); }},
          {"cost_us.p50,p99,max", "us", "of its frames", [](const L& l) { return timing_json(l.cost); }}};
}

double from_deadline(const LoopTimes& side) {
  return quantile_of(side.lateness, 0.5) + quantile_of(side.cost, 0.5);
}

double memory_growth(const std::vector<MemoryCourse>& runs) {
  std::vector<double> growth;
  for (const MemoryCourse& run : runs) growth.push_back(run.growth());
  return quantile_of(growth, 0.5);
}

Json row_of(const Laboratory& laboratory, const std::string& name, const std::string& baseline, double ours,
            double theirs, const Kind& kind) {
  return row_json({.name = name,
                   .baseline = baseline,
                   .ours_us = ours,
                   .baseline_us = theirs,
                   .error = p50_p95_max(kind.errors),
                   .n = laboratory.scene().model.neighbours},
                  {.scene = laboratory.name(), .body = laboratory.scene().body.get()});
}

struct LoopRow {
  const Kind& kind;
  const ConfidenceInterval& difference;
  int workers;
};

const JsonKeys<LoopRow>& loop_keys() {
  using R = LoopRow;
  static const JsonKeys<R> keys{
      {"record", "", "bench loop: true: with the record of inputs", [](const R& r) { return r.kind.record; }},
      {"seconds", "s", "time of the sessions", [](const R& r) { return r.kind.seconds; }},
      json_object<R, LoopTimes>(
          "loop", side_keys("frames of the session's loop, and those that missed their deadline"), "",
          [](const R& r) { return &r.kind.loop; }),
      json_object<R, LoopTimes>("bare", side_keys("the same of a bare loop at the same time"), "",
                                [](const R& r) { return &r.kind.bare; }),
      {"missed_difference.per_1000,low,high", "",
       "missed frames of a thousand more than the bare loop, with a 95 % interval",
       [](const R& r) {
         return json_numbers({r.difference.mean, r.difference.low, r.difference.high});
       }},
      {"missed_difference.within_noise", "", "true: the interval contains zero",
       [](const R& r) { return !r.difference.excludes_zero(); }},
      {"realtime_priority", "", "true: the loops had it", [](const R& r) { return r.kind.realtime; }},
      {"workers.count", "", "of the session", &R::workers},
      {"workers.busy", "1", "share of their time",
       [](const R& r) { return r.kind.busy / (r.kind.seconds * r.workers); }},
      {"workers.load_solves", "", "solves that kept the machine busy",
       [](const R& r) { return r.kind.load_solves; }},
      {"processors_used", "", "on average", [](const R& r) { return r.kind.cpu / r.kind.seconds; }},
      {"states.start,end", "", "known",
       [](const R& r) {
         return Json::array({r.kind.states_start, r.kind.states_end});
       }},
      {"memory.start,end", "bytes", "resident",  // of the first run, of the last
       [](const R& r) {
         return json_numbers({r.kind.memory.front().start(), r.kind.memory.back().end()});
       }},
      {"memory.growth_per_s", "bytes/s", "median of the runs",
       [](const R& r) { return memory_growth(r.kind.memory); }}};
  return keys;
}

const JsonKeys<bool>& verdict_keys() {
  static const JsonKeys<bool> keys{{"good", "", "true: no fault was found", [](bool good) { return good; }}};
  return keys;
}

Json loop_row(const Laboratory& laboratory, const Kind& kind, const ConfidenceInterval& difference,
              int workers) {
  Json row = row_of(laboratory, kind.record ? "loop, recording" : "loop", "bare loop",
                    from_deadline(kind.loop), from_deadline(kind.bare), kind);
  add_to(row, loop_keys(), {kind, difference, workers});
  return row;
}

std::string in_words(const Kind& kind, const ConfidenceInterval& d) {
  return fmt::format(
      "{}: missed {} of {} frames, bare loop {}; difference {:+.3g} per 1000 [{:.3g}, {:.3g}], {}; lateness "
      "p50 "
      "{:.3g} p99 {:.3g} us, bare {:.3g} {:.3g}; cost p50 {:.3g} p99 {:.3g} us; error p95 {:.2g}; {} states; "
      "resident {} to {}",
      kind.record ? "loop, recording" : "loop", kind.loop.missed, kind.loop.frames, kind.bare.missed, d.mean,
      d.low, d.high, d.excludes_zero() ? "not noise" : "within noise", quantile_of(kind.loop.lateness, 0.5),
      quantile_of(kind.loop.lateness, 0.99), quantile_of(kind.bare.lateness, 0.5),
      quantile_of(kind.bare.lateness, 0.99), quantile_of(kind.loop.cost, 0.5),
      quantile_of(kind.loop.cost, 0.99), quantile_of(kind.errors, 0.95), kind.states_end,
      bytes_in_words(kind.memory.front().start()), bytes_in_words(kind.memory.back().end()));
}

SessionOptions options_of(const Globals& globals, const Scene& scene, double seconds) {
  SessionOptions options = session_options(scene);
  options.model.fit = scene.model;
  options.clock.kind = Clock::real;
  options.clock.seconds = seconds;
  options.clock.length = RunLength::seconds;
  options.judging.reference_step = std::max(options.judging.reference_step, reference_step);
  options.judging.visit_stride = std::max(options.judging.visit_stride, 16);
  options.workers.threads = globals.threads;
  if (globals.seed != 0) options.seed = globals.seed;
  return options;
}

// The states of the finest lattice of at most `states` positions are known at the start, so that workers have nothing
// left to solve.
void add_states(Laboratory& laboratory, std::size_t states, SessionInput& input, Progress& progress) {
  const Box& box = laboratory.scene().space.box;
  const auto positions = [&](double h) {
    double count = 1;
    for (int axis = 0; axis < 3; ++axis)
      count *= 1 + std::floor(box.high[axis] / h + 1e-9) - std::ceil(box.low[axis] / h - 1e-9);
    return count;
  };
  double h = std::cbrt(box.size().prod() / static_cast<double>(states));
  while (positions(h) > static_cast<double>(states)) h *= 1.001;
  input.touched.space.spacing = h;
  input.known = laboratory.lattice_states(
      box, h, [&](double share, const std::string& text) { progress.show(share, text); });
}

// What the rows say against the loop; empty: nothing.
std::string verdict(const std::array<Kind, 2>& kinds, const std::array<ConfidenceInterval, 2>& differences) {
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].loop.frames == 0) continue;  // interrupted
    if (differences[i].low > 0)
      return fmt::format("the loop missed more deadlines than the bare loop, {:.3g} per 1000 frames",
                         differences[i].mean);
    if (const double cost = quantile_of(kinds[i].loop.cost, 0.99); cost >= most_cost)
      return fmt::format("the cost of a frame, p99, is {:.3g} us, expected below {:g}", cost, most_cost);
  }
  return {};
}

}  // namespace

DeclaredTable declared_bench_loop() {
  return bench_table("loop", {below("rows[]", declared(loop_keys())), declared(verdict_keys())});
}

int bench_loop(const Globals& globals, const std::string& scene, const LoopBench& bench) {
  if (bench.seconds / bench.blocks < 2)
    throw InputError("--seconds", fmt::format("gives blocks of {:g} s, expected at least 2 s in each of {}",
                                              bench.seconds / bench.blocks, bench.blocks));
  Laboratory laboratory(globals, scene);
  Progress progress(globals, "bench loop");
  const Scratch scratch;
  Setting setting{laboratory.scene(), laboratory.session_input(),
                  options_of(globals, laboratory.scene(), bench.seconds / bench.blocks), scratch.path()};
  if (bench.states > 0) add_states(laboratory, bench.states, setting.input, progress);
  setting.input.references =
      std::make_shared<ReferenceService>(reference_options(setting.input), globals.threads);
  const InterruptWatch watch;
  setting.options.stop.interrupted = &watch.flag();
  setting.options.stop.hurried = &watch.hurry();
  std::array<Kind, 2> kinds{Kind{.record = false}, Kind{.record = true}};
  const int runs = 2 * bench.blocks;
  for (int run = 0; run < runs && !watch.raised(); ++run)  // without, with, with, without …
    run_block(setting, kinds[static_cast<std::size_t>((run + 1) / 2 % 2)],
              [&](double share, const std::string& text) { progress.show((run + share) / runs, text); });
  std::array<ConfidenceInterval, 2> differences{};
  Json document{{"rows", Json::array()}};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].loop.frames == 0) continue;
    differences[i] = missed_difference(kinds[i].loop, kinds[i].bare, setting.options.clock.frame);
    document["rows"].push_back(loop_row(laboratory, kinds[i], differences[i], setting.options.workers.count));
  }
  const double with = quantile_of(kinds[1].loop.cost, 0.5), without = quantile_of(kinds[0].loop.cost, 0.5);
  if (std::isfinite(with + without))
    document["rows"].push_back(
        row_of(laboratory, "frame, recording", "frame, session.record = false", with, without, kinds[1]));
  const std::string problem = verdict(kinds, differences);
  const bool good = problem.empty() && !watch.raised();
  add_to(document, verdict_keys(), good);
  add_to(document, provenance_keys(), {laboratory.scene().source.hash});
  if (globals.json) print_json(document);
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i].loop.frames > 0) say(globals, in_words(kinds[i], differences[i]));
  if (good) return 0;
  warn(globals, problem.empty() ? "interrupted: the rows hold what was measured until then" : problem);
  return 1;
}

}  // namespace forefeel
