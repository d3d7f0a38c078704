#include "scheduling/judge/run_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "scheduling/judge/visited_cells.hpp"
#include "scheduling/render/session_model.hpp"

namespace forefeel {
namespace {

void judge(FrameRecord& frame, const Vec3& reference, const Vec3& fresh, double floor) {
  const double scale = std::max(reference.norm(), floor);
  Judgement& judged = frame.judged;
  judged.reference = reference;
  judged.error = (frame.force - reference).norm() / scale;
  judged.approximation = (frame.undamped - reference).norm() / scale;
  judged.switching = (frame.force - frame.undamped).norm() / scale;
  judged.staleness = (frame.undamped - fresh).norm() / scale;
}

// Which frames are samples: by arc length, and first visits of the cells of the lattice (cubes of h, or of a side of their
// own, whose corners lie in the box), of which every visit_stride-th counts.
class Samples {
 public:
  Samples(const StateSpaceOptions& space, const JudgingOptions& options)
      : visited_(space.box, visit_cell(options, space.spacing)),
        step_(options.reference_step),
        stride_(static_cast<std::size_t>(options.visit_stride)) {}

  struct Choice {
    bool sampled = false, first_visit = false;
  };
  Choice next(const Vec3& at) {
    Choice choice;
    if (begun_) travel_ += (at - last_).norm();
    begun_ = true;
    last_ = at;
    if (travel_ >= next_) {
      choice.sampled = true;
      next_ = (std::floor(travel_ / step_) + 1) * step_;
    }
    if (visited_.first(at)) choice.first_visit = (visited_.count() - 1) % stride_ == 0;
    return choice;
  }

 private:
  VisitedCells visited_;
  double step_, travel_ = 0, next_ = 0;
  std::size_t stride_;
  bool begun_ = false;
  Vec3 last_ = Vec3::Zero();
};

// Published models become switches when the loop takes them.
void keep_taken(SessionResult& result) {
  std::vector<SwitchRecord> taken;
  std::size_t published = 0;
  for (const FrameRecord& frame : result.frames) {
    if (!frame.step.took_model) continue;
    while (published < result.switches.size() && result.switches[published].model != frame.model) ++published;
    if (published == result.switches.size()) break;
    SwitchRecord record = result.switches[published++];
    record.t = frame.t;
    record.jump_undamped = frame.step.undamped_jump;
    taken.push_back(record);
  }
  result.switches = std::move(taken);
}

}  // namespace

// Frames and states are handed over in lots; one thread works them off in their order.
struct RunAnalysis::Impl {
  struct Frame {
    Vec3 at;
    std::uint32_t known;
  };
  struct Lot {
    std::vector<Frame> frames;
    std::vector<State> states;
  };
  struct Found {
    Label label;
    Samples::Choice choice;
    Vec3 fresh;  // where chosen: force of a model made anew from all states known then
  };
  static constexpr std::size_t lot_size = 100;

  Impl(const JudgeSetup& setup, ReferenceService& given, const std::function<void(const Vec3&)>& each)
      : references(given),
        each_position(each),
        end_early(setup.stop),
        patience(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
            std::chrono::duration<double>(setup.stop.patience))),
        samples(setup.space, setup.judging),
        space(setup.space),
        fresh(space, setup.model),
        floor(setup.judging.error_floor) {}

  // ---- of the thread that runs
  void add(const Vec3& at, std::uint32_t known, const StateSpace& all) {
    lot.frames.push_back({at, known});
    ++handed;
    if (lot.frames.size() == lot_size) hand_over(all);
  }
  void hand_over(const StateSpace& all) {
    for (; states < all.size(); ++states)
      lot.states.push_back(all[StateId{static_cast<std::uint32_t>(states)}]);
    hand_over();
  }
  void hand_over() {
    if (lot.frames.empty()) return;
    {
      const std::lock_guard lock(mutex);
      lots.push_back(std::move(lot));
      if (!thread.joinable()) thread = std::jthread([this](const std::stop_token& stop) { work(stop); });
    }
    lot = {};
    changed.notify_all();
  }
  void wait(const ShowProgress& show) {
    std::unique_lock lock(mutex);
    const auto done = [&] { return failure || worked == handed; };
    while (!changed.wait_for(lock, std::chrono::milliseconds(show ? 50 : 10'000), done))
      if (show)
        show({.phase = SessionPhase::labels,
              .t = static_cast<double>(worked),
              .seconds = static_cast<double>(handed),
              .known = states});
    if (failure) std::rethrow_exception(failure);
  }

  // ---- of the thread beside it
  void work(const std::stop_token& stop) {
    try {
      std::unique_lock lock(mutex);
      for (;;) {
        if (!changed.wait(lock, stop, [&] { return !lots.empty(); })) return;
        const Lot mine = std::move(lots.front());
        lots.pop_front();
        lock.unlock();
        arrived.insert(arrived.end(), mine.states.begin(), mine.states.end());
        for (const Frame& frame : mine.frames) {
          if (stop.stop_requested()) return;
          look_at(frame);
        }
        lock.lock();
        worked += mine.frames.size();
        changed.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
      changed.notify_all();
    }
  }
  void look_at(const Frame& frame) {
    bool grown = false;
    for (; inserted < std::min<std::size_t>(frame.known, arrived.size()); ++inserted) {
      space.insert(arrived[inserted]);
      grown = true;
    }
    if (each_frame) each_frame(found.size(), frame.at, frame.known);
    const bool as_before = !found.empty() && !grown && frame.at == last;  // a hand at rest
    last = frame.at;
    Found result{.label = as_before ? found.back().label : space.label(frame.at, walk),
                 .choice = samples.next(frame.at),
                 .fresh = Vec3::Zero()};
    if (result.choice.sampled || result.choice.first_visit) {
      references.request(frame.at);
      fresh.forget();  // no set of an earlier moment has a say
      result.fresh = fresh.model_at(frame.at).force(frame.at);
    }
    found.push_back(result);
    if (each_position) each_position(frame.at);
  }

  ReferenceService& references;
  std::function<void(const Vec3&)> each_position;
  const StopOptions end_early;
  std::chrono::steady_clock::duration patience;
  // of the thread that runs
  Lot lot;
  std::size_t handed = 0, states = 0;
  // of the other
  Samples samples;
  StateSpace space;  // what was known in the frame it is at
  SessionModel fresh;
  RunAnalysis::EachFrame each_frame;
  PathWalk walk;
  std::vector<State> arrived;  // all so far, of which `inserted` are in the space
  std::size_t inserted = 0;
  Vec3 last = Vec3::Zero();
  std::vector<Found> found;  // by frame; of the first again once `worked` says so
  // of both, under the mutex
  std::mutex mutex;
  std::condition_variable_any changed;
  std::deque<Lot> lots;
  std::size_t worked = 0;
  std::exception_ptr failure;
  double floor;         // f0 [N]
  std::jthread thread;  // ends first
};

RunAnalysis::RunAnalysis(const JudgeSetup& setup, ReferenceService& references,
                         const std::function<void(const Vec3&)>& each_position)
    : impl_(std::make_unique<Impl>(setup, references, each_position)) {}
RunAnalysis::~RunAnalysis() = default;

void RunAnalysis::frame(const Vec3& at, std::uint32_t known, const StateSpace& space) {
  impl_->add(at, known, space);
}

void RunAnalysis::begin(EachFrame each) {
  impl_->each_frame = std::move(each);
}
const StateSpace& RunAnalysis::space() const {
  return impl_->space;
}
void RunAnalysis::catch_up(const StateSpace& space) {
  impl_->hand_over(space);
  impl_->wait({});
}

// A label and what is a sample for every frame. Returns the samples.
std::vector<std::size_t> RunAnalysis::enter_labels(SessionResult& result) const {
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    const Impl::Found& found = impl_->found[k];
    FrameRecord& frame = result.frames[k];
    frame.label = found.label;
    frame.judged.sampled = found.choice.sampled;
    frame.judged.first_visit = found.choice.first_visit;
    if (found.choice.sampled || found.choice.first_visit) samples.push_back(k);
  }
  return samples;
}

void RunAnalysis::enter_errors(const std::vector<std::size_t>& samples, SessionResult& result,
                               const ShowProgress& show) {
  Impl& my = *impl_;
  // Who interrupts a run, now or before, does not want to wait for all that is still to be solved.
  constexpr auto never = std::chrono::steady_clock::time_point::max();
  auto end = never;
  const auto wait_for = [&](const Vec3& at) {
    for (;;) {
      const auto now = std::chrono::steady_clock::now();
      if (end == never && (result.interrupted() || my.end_early.is_interrupted())) end = now + my.patience;
      if (end != never && my.end_early.is_hurried()) end = std::min(end, now);
      const auto turn = std::min(end, now + std::chrono::milliseconds(100));
      std::optional<State> reference = my.references.get_until(at, turn);
      if (reference || turn == end) return reference;
    }
  };
  std::size_t failed = 0, late = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::optional<State> reference = wait_for(result.frames[samples[i]].at);
    if (!reference)
      ++late;
    else if (reference->usable())
      judge(result.frames[samples[i]], reference->force, my.found[samples[i]].fresh, my.floor);
    else
      ++failed;
    if (show)
      show({.phase = SessionPhase::references,
            .t = static_cast<double>(i + 1),
            .seconds = static_cast<double>(samples.size()),
            .known = result.states.size()});
  }
  if (late > 0) {
    if (result.end == RunEnd::whole) result.end = RunEnd::interrupted;
    result.notes.push_back(
        fmt::format("interrupted: {} of {} references were not waited for, those samples have no error", late,
                    samples.size()));
  }
  if (failed > 0)
    result.notes.push_back(std::to_string(failed) + " reference solves failed: those samples have no error");
}

void RunAnalysis::finish(SessionResult& result, const ShowProgress& show) {
  Impl& my = *impl_;
  for (; my.states < result.states.size(); ++my.states) my.lot.states.push_back(result.states[my.states]);
  for (std::size_t k = my.handed; k < result.frames.size(); ++k, ++my.handed)
    my.lot.frames.push_back({result.frames[k].at, result.frames[k].known});
  my.hand_over();
  my.wait(show);
  enter_errors(enter_labels(result), result, show);
  keep_taken(result);
}

}  // namespace forefeel
