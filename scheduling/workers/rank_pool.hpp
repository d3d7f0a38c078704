#pragma once
// The other ranks of a run, as rank 0 sees them: which ranks take jobs, what they return, and which hang. A rank that
// sends an unreadable message counts as failed; the message is dropped.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "scheduling/workers/transport.hpp"

namespace forefeel {

struct RankEvent {
  // lost: the rank hangs or has failed; others must do its work
  enum class Kind { ready, result, question, lost };
  Kind kind = Kind::result;
  int rank = 0;
  std::uint64_t job = 0;  // that a result names, unchecked
  Bytes content = {};
};

class RankPool {
 public:
  using Clock = std::function<double()>;  // [s]
  // patience: seconds of silence after which a rank counts as hanging; time in which rank 0 itself was stopped does not
  // count. clock: empty for the steady clock.
  explicit RankPool(Transport& transport, double patience = 10, Clock clock = {});

  // Tells the other ranks to load. identity: of build and input; a rank with a different identity gets no work.
  // said: a message with data that only rank 0 has, such as a spacing that it measured (RankContext::begun()).
  void begin(std::string identity, const Bytes& said = {});
  int ranks() const;                // without rank 0
  bool takes_jobs(int rank) const;  // has loaded its input, and answers
  bool is_pending(int rank) const;  // has not loaded its input yet, and answers
  int taking_jobs() const;          // how many
  void send(int rank, std::uint64_t job, const Bytes& content);
  void cancel(int rank);
  void answer(int rank, Bytes content);  // a question
  // What has happened since the last call; does not wait. A rank that answers again after it was lost is
  // ready again.
  std::vector<RankEvent> poll();
  // Polls until no rank is pending, but at most so long [s].
  std::vector<RankEvent> wait_until_loaded(double seconds);
  // Tells all ranks to stop, and waits until they have left or hang. Results that came until then are
  // returned.
  std::vector<RankEvent> stop();
  bool all_left() const;  // after stop(); false: a rank hangs, and the run can only be ended from outside

  // Ranks that are lost, and what else the user should know, one line each.
  int lost() const;
  const std::vector<std::string>& notes() const { return notes_; }
  void distrust(int rank);  // its result could not be read: the rank counts as failed

 private:
  enum class Life { waiting, loading, working, failed, left };
  struct Rank {
    Life life = Life::waiting;
    bool silent = false;  // for longer than the patience
    double silence = 0;   // [s]
    bool answers() const { return !silent && life != Life::failed && life != Life::left; }
  };
  Rank& of(int rank) { return ranks_[rank - 1]; }
  const Rank& of(int rank) const { return ranks_[rank - 1]; }
  void send(int rank, RankTag tag, Bytes bytes = {});
  void take(Message message, std::vector<RankEvent>& events);
  void receive(int rank, std::vector<RankEvent>& events);
  void take_ready(int rank, Unpacker message, std::vector<RankEvent>& events);
  void fail(int rank, const std::string& why, std::vector<RankEvent>& events);
  void check_silence(double passed, std::vector<RankEvent>& events);
  void beat(double now);

  Transport& transport_;
  double patience_;
  std::string identity_;
  Clock clock_;
  SignedVector<Rank> ranks_;
  std::vector<std::string> notes_;
  std::vector<RankEvent> later_;  // for the next poll()
  double polled_ = 0, beaten_ = 0;
  bool stopping_ = false;
};

}  // namespace forefeel
