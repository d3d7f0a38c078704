#pragma once
// A state as part of a message between processes: every value, bit by bit.

#include "geometry/common/packer.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

void pack(Packer& message, const State& state);
State unpack_state(Unpacker& message);  // MalformedMessage

}  // namespace forefeel
