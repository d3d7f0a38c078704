#pragma once
// Ranks in one process: threads, or tests that play a rank, with mailboxes in memory.

#include <deque>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "scheduling/workers/transport.hpp"

namespace forefeel::test {

// Mailboxes in memory. A rank that no thread serves appears to hang.
struct Mail {
  explicit Mail(int count) : boxes(static_cast<std::size_t>(count)) {}
  void put(int to, Message message) {
    const std::lock_guard lock(mutex);
    boxes.at(static_cast<std::size_t>(to)).push_back(std::move(message));
  }
  std::optional<Message> get(int rank) {
    const std::lock_guard lock(mutex);
    auto& box = boxes.at(static_cast<std::size_t>(rank));
    if (box.empty()) return {};
    Message message = std::move(box.front());
    box.pop_front();
    return message;
  }
  std::mutex mutex;
  std::vector<std::deque<Message>> boxes;
};

class Endpoint final : public Transport {
 public:
  Endpoint(Mail& mail, int rank) : mail_(mail), rank_(rank) {}
  int rank() const override { return rank_; }
  int ranks() const override { return static_cast<int>(mail_.boxes.size()); }
  void send(int to, int tag, Bytes bytes) override { mail_.put(to, {rank_, tag, std::move(bytes)}); }
  std::optional<Message> receive() override { return mail_.get(rank_); }

  void say(RankTag tag, Bytes bytes = {}) { send(0, static_cast<int>(tag), std::move(bytes)); }
  void say_ready(std::string_view identity = "same") { say(RankTag::ready, bytes_of(identity)); }
  static Bytes bytes_of(std::string_view text) {
    Packer message;
    message.add(text);
    return message.take();
  }

 private:
  Mail& mail_;
  int rank_;
};

}  // namespace forefeel::test
