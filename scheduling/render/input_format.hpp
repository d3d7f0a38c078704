#pragma once
// The file of a run's inputs (RUN/session.inputs), written by input_log.hpp and read by input_reader.hpp.
//   "forefeel inputs 1\n", header, records
// The header and each record stand behind a kind (one letter) and the length of their content (32 bits). Numbers are
// as they stand in memory, every double with all its bits. The header ends with a digest of itself.
//   H   what the run was made with (InputHeader)
//   S   a state that became known, in the order of the state space (geometry/states/state_message.hpp)
//   X   a state that did not: its solve failed, or it was set aside (scheduling/session/plausible.hpp)
//   M   a model was made (ModelInput)
//   F   a frame (FrameInput)
//   E   the run ended by itself; a file without it was cut, and holds what was written until then
// States and models stand before the first frame that knows them. 118 bytes a frame, 7.1 MB a minute at 1 kHz.

#include <cstdint>
#include <string>
#include <string_view>

#include "geometry/common/packer.hpp"
#include "geometry/coverage/state_space_options.hpp"
#include "scheduling/render/frame_input.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/session_model_options.hpp"

namespace forefeel {

inline constexpr std::string_view inputs_magic = "forefeel inputs 1\n";

enum class InputKind : char { header = 'H', state = 'S', failed = 'X', model = 'M', frame = 'F', end = 'E' };

struct InputHeader {
  std::string made_by;  // program and instruction set: other ones may round otherwise
  bool real = false;    // clock
  std::uint64_t frames = 0, spare = 0;
  RenderOptions render = {};
  ModelRecipe model = {};
  StateSpaceOptions space = {};  // without an adaptive lattice
};

// One call of SessionModel::update().
struct ModelInput {
  Vec3 hip = Vec3::Zero();   // [m]
  std::uint32_t states = 0;  // in the space then
  std::uint64_t serial = 0;  // of the model that was made; 0: none could be
  bool published = false;    // to the loop
};

// A text that changes with the program and the instruction set that this process uses.
std::string inputs_made_by(std::string_view program);

void pack(Packer& out, const InputHeader& header);
void pack(Packer& out, const ModelInput& model);
void pack(Packer& out, const FrameInput& frame);
// MalformedMessage where the bytes hold something else.
InputHeader unpack_header(Unpacker& in);
ModelInput unpack_model(Unpacker& in);
FrameInput unpack_frame(Unpacker& in);

// A record: kind, length, content.
void pack_record(Packer& out, InputKind kind, const Bytes& content);

}  // namespace forefeel
