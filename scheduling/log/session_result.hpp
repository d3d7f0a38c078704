#pragma once
// What a session gives back, and what it tells while it runs. record/run_files.hpp writes its files and
// derives the summary from it.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "scheduling/log/records.hpp"

namespace forefeel {

struct StateCounts {
  std::size_t start = 0, solved = 0, failed = 0, preempted = 0;
};

// What safety did (render/safety.hpp), and the hand's work by the energy observer.
struct SafetyReport {
  std::size_t clamped = 0, slewed = 0, stale = 0, non_finite = 0;  // frames
  double generated = 0;  // most energy that was given back beyond what was put in [J]
  double work = 0;       // sum of |F . dx| [J]
};

struct SolverReport {
  std::vector<double> seconds;  // of each solve of the session but rest first, virtual or real [s]
  std::size_t jobs = 0;         // that these came in; each took its worker two messages more
  int workers = 0;              // that took part
};

struct ProcessReport {             // real clock only
  bool realtime_priority = false;  // of the loop's thread
  bool memory_locked = false;
};

enum class RunEnd {
  whole,
  interrupted,  // fewer frames than were asked for, or samples without a reference
  not_begun     // interrupted while a clairvoyant session rehearsed: no frames, no solves
};

struct SessionResult {
  std::vector<FrameRecord> frames;
  std::vector<DispatchRecord> dispatch;
  std::vector<SwitchRecord> switches;
  std::vector<State> states;  // all known at the end, those of the start first
  StateCounts counts;
  SafetyReport safety;
  SolverReport solver;
  ProcessReport process;
  double wall_seconds = 0;  // of the session, its labels and its references; not of reading and writing files
  RunEnd end = RunEnd::whole;
  std::vector<std::string> notes;     // what the system did not permit, what failed
  std::vector<std::string> warnings;  // about files that were read, one line each
  bool interrupted() const { return end != RunEnd::whole; }
};

enum class SessionPhase { arrivals, session, labels, references };
std::string_view name(SessionPhase phase);

struct SessionProgress {
  SessionPhase phase = SessionPhase::session;
  double t = 0, seconds = 0;  // [s] in phase session; else how many of how many
  std::size_t known = 0, solved = 0;
  Label label = Label::blank;
  double force = 0;  // [N]
  // Where a clairvoyant session rehearses: which schedule of how many (0: it does not).
  std::size_t rehearsal = 0, rehearsals = 0;
};
// "labels", or "rehearsal 2 of 7, labels".
std::string phase_in_words(const SessionProgress& progress);
using ShowProgress = std::function<void(const SessionProgress&)>;

}  // namespace forefeel
