#include "scheduling/workers/rank_pool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void check_patience(double seconds) {
  if (!(seconds >= 1 && std::isfinite(seconds)))
    throw InputError("--patience",
                     fmt::format("is {:g} s, expected at least 1 (a rank answers twice a second)", seconds));
}

RankPool::RankPool(Transport& transport, double patience, Clock clock)
    : transport_(transport),
      patience_(patience),
      clock_(clock ? std::move(clock) : steady_seconds),
      ranks_(static_cast<std::size_t>(transport.ranks() - 1)),
      polled_(clock_()),
      beaten_(polled_) {}

int RankPool::ranks() const {
  return ranks_.count();
}

bool RankPool::takes_jobs(int rank) const {
  return of(rank).life == Life::working && !of(rank).silent;
}

bool RankPool::is_pending(int rank) const {
  return of(rank).life == Life::loading && !of(rank).silent;
}

int RankPool::taking_jobs() const {
  int count = 0;
  for (int rank = 1; rank <= ranks(); ++rank) count += takes_jobs(rank) ? 1 : 0;
  return count;
}

int RankPool::lost() const {
  return static_cast<int>(std::ranges::count_if(
      ranks_, [](const Rank& rank) { return rank.life != Life::left && !rank.answers(); }));
}

bool RankPool::all_left() const {
  return std::ranges::all_of(ranks_, [](const Rank& rank) { return rank.life == Life::left; });
}

void RankPool::send(int rank, RankTag tag, Bytes bytes) {
  transport_.send(rank, static_cast<int>(tag), std::move(bytes));
}

void RankPool::begin(std::string identity, const Bytes& said) {
  identity_ = std::move(identity);
  for (int rank = 1; rank <= ranks(); ++rank) {
    of(rank).life = Life::loading;
    send(rank, RankTag::begin, said);
  }
}

void RankPool::send(int rank, std::uint64_t job, const Bytes& content) {
  Packer message;
  message.add(job);
  message.add_raw(content);
  send(rank, RankTag::job, message.take());
}

void RankPool::cancel(int rank) {
  send(rank, RankTag::cancel);
}

void RankPool::distrust(int rank) {
  fail(rank, fmt::format("rank {} sent a message without meaning; it gets no more work", rank), later_);
}

void RankPool::answer(int rank, Bytes content) {
  send(rank, RankTag::answer, std::move(content));
}

std::vector<RankEvent> RankPool::poll() {
  std::vector<RankEvent> events = std::exchange(later_, {});
  while (auto message = transport_.receive()) take(std::move(*message), events);
  const double now = clock_();
  check_silence(std::min(now - polled_, longest_step), events);
  polled_ = now;
  beat(now);
  return events;
}

std::vector<RankEvent> RankPool::wait_until_loaded(double seconds) {
  std::vector<RankEvent> all;
  const double until = clock_() + seconds;
  for (bool pending = true; pending && clock_() < until;) {
    for (RankEvent& event : poll()) all.push_back(std::move(event));
    pending = false;
    for (int rank = 1; rank <= ranks(); ++rank) pending = pending || is_pending(rank);
    if (pending) std::this_thread::sleep_for(poll_pause);
  }
  return all;
}

std::vector<RankEvent> RankPool::stop() {
  std::vector<RankEvent> results;
  if (stopping_) return results;
  stopping_ = true;
  for (int rank = 1; rank <= ranks(); ++rank) send(rank, RankTag::stop);
  const auto awaited = [](const Rank& rank) { return rank.life != Life::left && !rank.silent; };
  while (std::ranges::any_of(ranks_, awaited)) {
    for (RankEvent& event : poll())
      if (event.kind == RankEvent::Kind::result) results.push_back(std::move(event));
    std::this_thread::sleep_for(poll_pause);
  }
  return results;
}

void RankPool::take(Message message, std::vector<RankEvent>& events) {
  const int rank = message.rank;
  if (rank < 1 || rank > ranks()) return;
  try {
    Unpacker content(std::move(message.bytes));
    switch (static_cast<RankTag>(message.tag)) {
      case RankTag::ready:
        take_ready(rank, std::move(content), events);
        break;
      case RankTag::beat:
        break;
      case RankTag::left:
        of(rank).life = Life::left;
        return;
      case RankTag::failure:
        fail(rank, fmt::format("rank {} has failed: {}", rank, content.text()), events);
        break;
      case RankTag::question:
        events.push_back({.kind = RankEvent::Kind::question, .rank = rank, .content = content.rest()});
        break;
      case RankTag::result: {
        const auto job = content.number<std::uint64_t>();
        events.push_back(
            {.kind = RankEvent::Kind::result, .rank = rank, .job = job, .content = content.rest()});
        break;
      }
      default:
        throw MalformedMessage("unknown kind");
    }
  } catch (const MalformedMessage&) {
    distrust(rank);
  }
  receive(rank, events);
}

// Any message shows that the rank lives.
void RankPool::receive(int rank, std::vector<RankEvent>& events) {
  Rank& its = of(rank);
  its.silence = 0;
  if (!its.silent) return;
  its.silent = false;
  if (stopping_ || its.life == Life::failed) return;
  notes_.push_back(fmt::format("rank {} answers again", rank));
  if (its.life == Life::working) events.push_back({.kind = RankEvent::Kind::ready, .rank = rank});
}

void RankPool::take_ready(int rank, Unpacker message, std::vector<RankEvent>& events) {
  const std::string identity = message.text();
  message.expect_end();
  Rank& its = of(rank);
  if (its.life != Life::loading) throw MalformedMessage("ready twice, or before it was asked");
  if (identity != identity_)
    return fail(rank, fmt::format("rank {} has another build or other input; it gets no work", rank), events);
  its.life = Life::working;
  if (!its.silent) events.push_back({.kind = RankEvent::Kind::ready, .rank = rank});
}

void RankPool::fail(int rank, const std::string& why, std::vector<RankEvent>& events) {
  Rank& its = of(rank);
  if (its.life == Life::failed || its.life == Life::left) return;
  its.life = Life::failed;
  if (stopping_) return;
  notes_.push_back(why);
  if (!its.silent) events.push_back({.kind = RankEvent::Kind::lost, .rank = rank});
}

void RankPool::check_silence(double passed, std::vector<RankEvent>& events) {
  for (int rank = 1; rank <= ranks(); ++rank) {
    Rank& its = of(rank);
    if (its.silent || its.life == Life::left) continue;
    its.silence += passed;
    if (its.silence <= patience_) continue;
    its.silent = true;
    if (stopping_ || its.life == Life::failed) continue;
    notes_.push_back(
        fmt::format("rank {} has not answered for {:g} s; its work goes to others", rank, patience_));
    events.push_back({.kind = RankEvent::Kind::lost, .rank = rank});
  }
}

// Lets the ranks notice when rank 0 is gone.
void RankPool::beat(double now) {
  if (now - beaten_ < beat_seconds) return;
  beaten_ = now;
  for (int rank = 1; rank <= ranks(); ++rank)
    if (!of(rank).silent && of(rank).life != Life::left) send(rank, RankTag::beat);
}

}  // namespace forefeel
