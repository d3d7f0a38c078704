#pragma once
// The file of a run's inputs (RUN/session.inputs), written by input_log.hpp and read by InputReader.
//   "forefeel inputs 1\n", header, records
// The header and each record begin with a kind (one letter) and the length of their content (32 bits). Numbers have
// their form in memory, every double all its bits. The header ends with a digest of itself.
//   H   settings of the run (InputHeader)
//   A   of a body that may be touched anywhere: its settings in words (session/input_replay.hpp), before all others
//   S   a state that became known, in the order of the state space (geometry/states/state_message.hpp)
//   X   a state that did not become known: its solve failed, or it was set aside (scheduling/session/plausible.hpp)
//   M   a model was made (ModelInput)
//   F   a frame (FrameInput)
//   E   the end of the run; a file without it is of an interrupted run, and has the records written until then
// States and models come before the first frame that uses them. 118 bytes a frame, 7.1 MB a minute at 1 kHz.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/common/packer.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/render/frame_input.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/session_model_options.hpp"

namespace forefeel {

inline constexpr std::string_view inputs_magic = "forefeel inputs 1\n";

enum class InputKind : char {
  header = 'H',
  surface = 'A',
  state = 'S',
  failed = 'X',
  model = 'M',
  frame = 'F',
  end = 'E'
};

struct InputHeader {
  std::string made_by;  // program and instruction set: others may round differently
  bool real = false;    // clock
  std::uint64_t frames = 0, spare = 0;
  RenderOptions render = {};
  ModelRecipe model = {};
  StateSpaceOptions space = {};  // without an adaptive lattice
  std::string surface = {};      // record A; empty: one place of contact
};

// One call of SessionModel::update(), or of SurfaceModels::newest().
struct ModelInput {
  Vec3 hip = Vec3::Zero();   // [m]
  std::uint32_t states = 0;  // in the space then
  std::uint64_t serial = 0;  // of the model that was made; 0: none could be
  bool published = false;    // to the loop
};

// A text that names the program and the instruction set of this process.
std::string inputs_made_by(std::string_view program);

void pack(Packer& out, const InputHeader& header);
void pack(Packer& out, const ModelInput& model);
void pack(Packer& out, const FrameInput& frame);
// Throws MalformedMessage if the bytes are not a header.
InputHeader unpack_header(Unpacker& in);
ModelInput unpack_model(Unpacker& in);
FrameInput unpack_frame(Unpacker& in);

// A record: kind, length, content.
void pack_record(Packer& out, InputKind kind, const Bytes& content);

// Reads the file of a run's inputs record by record, with little memory however long it is.
// The file of an interrupted run ends within a record, or without the end record; its complete records are used.
// Anything else that is no record is damage.

struct InputRecord {
  InputKind kind = InputKind::end;
  Bytes content;
  std::uint64_t at = 0;  // where it begins in the file [bytes]
};

class InputReader {
 public:
  // InputError: no such file, another format, or a damaged header.
  explicit InputReader(std::filesystem::path file);

  const InputHeader& header() const { return header_; }
  // The next record; none at the end. InputError where the bytes are no record.
  std::optional<InputRecord> next();
  bool whole() const { return whole_; }  // the record of the end was read
  std::uint64_t bytes() const { return bytes_; }

  // Throws InputError: the file is damaged at this record.
  [[noreturn]] void refuse(const InputRecord& record, const std::string& problem) const;

 private:
  std::optional<InputRecord> read();

  std::filesystem::path file_;
  std::ifstream in_;
  std::uint64_t at_ = 0, bytes_ = 0;
  bool whole_ = false;
  InputHeader header_;
};

}  // namespace forefeel
