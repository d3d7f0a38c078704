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

InputLog::Disk::Disk(std::filesystem::path file) : file_(std::move(file)) {
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw InputError({.file = file_.string()}, fmt::format("cannot be written: {}", std::strerror(errno)));
}

std::size_t InputLog::Disk::put(const Bytes& bytes) {
  std::size_t done = 0;
  while (done < bytes.size() && descriptor_ >= 0) {
    const ssize_t count = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

bool InputLog::Disk::write(const Bytes& bytes) {
  if (put(bytes) == bytes.size()) return true;
  fail(std::strerror(errno));
  return false;
}

bool InputLog::Disk::close() {
  const int open = std::exchange(descriptor_, -1);
  return open < 0 || ::close(open) == 0;
}

void InputLog::Disk::fail(const std::string& why) {
  if (failure) return;
  failure = fmt::format("{}: cannot be written: {}; frames after {:.3f} s cannot be replayed", file_.string(),
                        why, last_t);
  close();
}

InputLog::InputLog(std::filesystem::path file, const InputHeader& header, bool thread)
    : disk_(std::move(file)) {
  frames_.seconds = header.render.frame;
  Packer begin;
  begin.add_raw(inputs_magic);
  pack_record(begin, InputKind::header, content_of(header));
  if (!header.surface.empty()) {
    Packer surface;
    surface.add_raw(header.surface);
    pack_record(begin, InputKind::surface, surface.take());
  }
  disk_.write(begin.take());
  if (!thread) return;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      drain();
      std::this_thread::sleep_for(pause);
    }
  });
}

void InputLog::end_thread() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void InputLog::frame(const FrameInput& frame) noexcept {
  if (frames_.full.load(std::memory_order_relaxed)) return;
  if (!frames_.queue.push(frame)) frames_.full.store(true, std::memory_order_relaxed);
}

void InputLog::plan(InputKind kind, const Bytes& content) {
  const std::lock_guard lock(planned_.mutex);
  pack_record(planned_.bytes, kind, content);
}

void InputLog::learn(const StateSpace& space) {
  for (; planned_.learned < space.size(); ++planned_.learned)
    plan(InputKind::state, content_of(space[StateId{planned_.learned}]));
}

void InputLog::learn(std::span<const State> known) {
  for (; planned_.learned < known.size(); ++planned_.learned)
    plan(InputKind::state, content_of(known[planned_.learned]));
}

void InputLog::model(const ModelInput& model) {
  plan(InputKind::model, content_of(model));
}

void InputLog::failed(const State& state) {
  plan(InputKind::failed, content_of(state));
}

// Frames are taken first: the models that came with them were recorded before them, and are written before them.
void InputLog::drain() {
  Bytes frames;
  struct Written {
    std::size_t end;  // in the bytes of the frames
    double t;
  };
  std::vector<Written> ends;
  while (const std::optional<FrameInput> frame = frames_.queue.pop()) {
    Packer record;
    pack_record(record, InputKind::frame, content_of(*frame));
    const Bytes bytes = record.take();
    frames.insert(frames.end(), bytes.begin(), bytes.end());
    ends.push_back({frames.size(), frame->frame * frames_.seconds});
  }
  Bytes planned;
  {
    const std::lock_guard lock(planned_.mutex);
    planned = planned_.bytes.take();
  }
  if (!disk_.write(planned)) return;
  const std::size_t done = disk_.put(frames);
  for (const Written& frame : ends)
    if (frame.end <= done) disk_.last_t = frame.t;
  if (done < frames.size()) disk_.fail(std::strerror(errno));
}

void InputLog::close() {
  end_thread();
  drain();
  if (frames_.full.load()) disk_.fail("the disk was too slow");
  Packer end;
  pack_record(end, InputKind::end, {});
  disk_.write(end.take());
  if (!disk_.close()) disk_.fail(std::strerror(errno));
}

}  // namespace forefeel
