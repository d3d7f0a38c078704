#pragma once
// Messages between the processes (ranks) of one run. Rank 0 gives out work, the others solve. Calls come from one
// thread at a time and never wait for another rank.

#include <optional>

#include "geometry/common/packer.hpp"

namespace forefeel {

struct Message {
  int rank = 0;  // the sender
  int tag = 0;
  Bytes bytes;
};

class Transport {
 public:
  virtual ~Transport() = default;
  virtual int rank() const = 0;  // of this process
  virtual int ranks() const = 0;
  // Messages from one rank to another arrive in their order. To a rank that hangs, they wait here.
  virtual void send(int rank, int tag, Bytes bytes) = 0;
  virtual std::optional<Message> receive() = 0;  // nullopt: none is there
};

}  // namespace forefeel
