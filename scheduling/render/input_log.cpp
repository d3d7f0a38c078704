#include "scheduling/render/input_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/states/state_message.hpp"

namespace forefeel {
namespace {

constexpr auto pause = std::chrono::milliseconds(20);

template <class Value>
Bytes content_of(const Value& value) {
  Packer content;
  pack(content, value);
  return content.take();
}

Bytes content_of(State state) {
  state.displacements.reset();  // no model reads them
  Packer content;
  pack(content, state);
  return content.take();
}

}  // namespace

InputLog::InputLog(std::filesystem::path file, const InputHeader& header, bool thread)
    : file_(std::move(file)), frame_seconds_(header.render.frame) {
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw InputError({.file = file_.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
  Packer begin;
  begin.add_raw(inputs_magic);
  pack_record(begin, InputKind::header, content_of(header));
  write(begin.take());
  if (!thread) return;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      drain();
      std::this_thread::sleep_for(pause);
    }
  });
}

InputLog::~InputLog() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  if (descriptor_ >= 0) ::close(descriptor_);
}

void InputLog::frame(const FrameInput& frame) noexcept {
  if (full_.load(std::memory_order_relaxed)) return;
  if (!frames_.push(frame)) full_.store(true, std::memory_order_relaxed);
}

void InputLog::learn(const StateSpace& space) {
  for (; learned_ < space.size(); ++learned_) {
    const Bytes content = content_of(space[StateId{learned_}]);
    const std::lock_guard lock(mutex_);
    pack_record(planned_, InputKind::state, content);
  }
}

void InputLog::model(const ModelInput& model) {
  const Bytes content = content_of(model);
  const std::lock_guard lock(mutex_);
  pack_record(planned_, InputKind::model, content);
}

void InputLog::failed(const State& state) {
  const Bytes content = content_of(state);
  const std::lock_guard lock(mutex_);
  pack_record(planned_, InputKind::failed, content);
}

// Frames are taken first: the models that came with them were recorded before them, and are written before them.
void InputLog::drain() {
  Bytes frames;
  struct Written {
    std::size_t end;  // in the bytes of the frames
    double t;
  };
  std::vector<Written> ends;
  while (const std::optional<FrameInput> frame = frames_.pop()) {
    Packer record;
    pack_record(record, InputKind::frame, content_of(*frame));
    const Bytes bytes = record.take();
    frames.insert(frames.end(), bytes.begin(), bytes.end());
    ends.push_back({frames.size(), frame->frame * frame_seconds_});
  }
  Bytes planned;
  {
    const std::lock_guard lock(mutex_);
    planned = planned_.take();
  }
  if (!write(planned)) return;
  const std::size_t done = put(frames);
  for (const Written& frame : ends)
    if (frame.end <= done) last_t_ = frame.t;
  if (done < frames.size()) fail(std::strerror(errno));
}

void InputLog::close() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  drain();
  if (full_.load()) fail("the disk was too slow");
  Packer end;
  pack_record(end, InputKind::end, {});
  write(end.take());
  if (descriptor_ >= 0 && ::close(descriptor_) != 0) fail(std::strerror(errno));
  descriptor_ = -1;
}

// Returns how many bytes are in the file; errno says why it is not all.
std::size_t InputLog::put(const Bytes& bytes) {
  std::size_t done = 0;
  while (done < bytes.size() && descriptor_ >= 0) {
    const ssize_t count = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

bool InputLog::write(const Bytes& bytes) {
  if (put(bytes) == bytes.size()) return true;
  fail(std::strerror(errno));
  return false;
}

void InputLog::fail(const std::string& why) {
  if (failure_) return;
  failure_ = fmt::format("{}: cannot be written: {}; frames after {:.3f} s cannot be replayed",
                         file_.string(), why, last_t_);
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace forefeel
