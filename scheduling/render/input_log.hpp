#pragma once
// Records the inputs of a run, so that it can be rendered again bit by bit (session/input_replay.hpp). The format is in
// input_format.hpp. Three threads use the log:
//   loop      frame(): a copy into a queue, which neither allocates nor locks
//   planner   learn(), failed(), model(): bytes under a lock that is held only briefly
//   writer    drain(): to the disk; a thread of the log, or the caller under the virtual clock
// Every record reaches the file within about 20 ms, so the file of a killed run can be replayed. If the disk fails, or
// is so slow that the queue is full (8 s of frames), recording ends, the run continues, and failure() says so.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/render/input_format.hpp"
#include "scheduling/render/spsc_queue.hpp"

namespace forefeel {

class InputLog {
 public:
  // Makes the file and writes the header. With `thread`, a thread of the log calls drain(). InputError if the file
  // cannot be written.
  InputLog(std::filesystem::path file, const InputHeader& header, bool thread);
  ~InputLog() { end_thread(); }
  InputLog(const InputLog&) = delete;
  InputLog& operator=(const InputLog&) = delete;

  void frame(const FrameInput& frame) noexcept;  // the loop's thread

  // Call before a model is made from the space: records its states that are not recorded yet. Always the same space.
  void learn(const StateSpace& space);
  void learn(std::span<const State> known);  // the same of a body that is touched anywhere, in their order
  void model(const ModelInput& model);       // before the model is published
  void failed(const State& state);           // any thread

  void drain();  // one thread; not with a thread of the log
  void close();  // after the last frame: drains, marks the end, closes the file
  const std::optional<std::string>& failure() const { return disk_.failure; }  // after close(); one line

 private:
  class Disk {  // the file, until it fails
   public:
    explicit Disk(std::filesystem::path file);
    ~Disk() { close(); }
    // Returns how many bytes are in the file; errno says why it is not all.
    std::size_t put(const Bytes& bytes);
    bool write(const Bytes& bytes);  // false: it has failed
    bool close();                    // false: the system refused; errno says why
    void fail(const std::string& why);

    double last_t = 0;  // of the frames that are in the file [s]
    std::optional<std::string> failure = {};

   private:
    std::filesystem::path file_;
    int descriptor_ = -1;
  };
  struct Frames {  // of the loop
    SpscQueue<FrameInput, 8192> queue;
    std::atomic<bool> full{false};  // a frame was lost: recording ends before it
    double seconds = 0;             // of one frame
  };
  struct Planned {     // records of the planner
    std::mutex mutex;  // of bytes
    Packer bytes;
    std::uint32_t learned = 0;  // states recorded; planner's thread
  };
  void plan(InputKind kind, const Bytes& content);
  void end_thread();

  Disk disk_;
  Frames frames_;
  Planned planned_;
  std::jthread thread_;
};

}  // namespace forefeel
