#include "scheduling/render/input_reader.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel {
namespace {

constexpr std::uint64_t most_content = 1
                                       << 20;  // [bytes]; a header with many viscous branches is the largest
constexpr std::uint64_t state_size = 191, model_size = 37, frame_size = 113;

// Of a state without displacements; with a jet: its order, limit and coefficients behind it.
bool fits_state(std::uint64_t length) {
  for (const std::uint64_t size : {state_size, state_size + sizeof(Vec3)}) {  // with a site
    if (length == size) return true;
    for (int order = 2; order <= most_jet_order; ++order)
      if (length == size + 1 + sizeof(double) * (1 + jet_terms_of_order(order))) return true;
  }
  return false;
}

// Whether a record of this kind may be so long. Headers have no fixed length.
bool fits(InputKind kind, std::uint64_t length) {
  switch (kind) {
    case InputKind::header:
    case InputKind::surface:
      return length <= most_content;
    case InputKind::state:
    case InputKind::failed:
      return fits_state(length);
    case InputKind::model:
      return length == model_size;
    case InputKind::frame:
      return length == frame_size;
    case InputKind::end:
      return length == 0;
  }
  return false;
}

}  // namespace

InputReader::InputReader(std::filesystem::path file) : file_(std::move(file)), in_(file_, std::ios::binary) {
  if (!in_)
    throw InputError({.file = file_.string()},
                     "cannot be read, expected the record of a run (session.record of its scene)");
  std::string magic(inputs_magic.size(), '\0');
  in_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  if (magic != inputs_magic)
    throw InputError({.file = file_.string()}, "is no record of a run, expected one of this version");
  at_ = magic.size();
  const std::optional<InputRecord> first = read();
  if (!first || first->kind != InputKind::header)
    throw InputError({.file = file_.string()}, "ends before the first frame, expected the record of a run");
  try {
    Unpacker content(first->content);
    header_ = unpack_header(content);
  } catch (const MalformedMessage& problem) {
    refuse(*first, problem.what());
  }
}

std::optional<InputRecord> InputReader::next() {
  if (whole_) return {};
  std::optional<InputRecord> record = read();
  if (!record) return {};
  if (record->kind == InputKind::header) refuse(*record, "a second header");
  whole_ = record->kind == InputKind::end;
  if (whole_ && in_.peek() != std::ifstream::traits_type::eof()) {
    ++record->at;
    refuse(*record, "bytes behind the end");
  }
  return whole_ ? std::optional<InputRecord>() : record;
}

std::optional<InputRecord> InputReader::read() {
  char start[5] = {};
  in_.read(start, sizeof start);
  if (in_.gcount() == 0) return {};
  InputRecord record{.kind = static_cast<InputKind>(start[0]), .content = {}, .at = at_};
  std::uint32_t length = 0;
  std::memcpy(&length, start + 1, sizeof length);
  const bool cut = in_.gcount() < static_cast<std::streamsize>(sizeof start);
  if (!cut && !fits(record.kind, length)) refuse(record, "no record of a run begins there");
  if (cut) return {};
  record.content.resize(length);
  if (length > 0) in_.read(record.content.data(), length);
  if (length > 0 && in_.gcount() < static_cast<std::streamsize>(length)) return {};
  at_ += sizeof start + length;
  bytes_ = at_;
  return record;
}

void InputReader::refuse(const InputRecord& record, const std::string& problem) const {
  throw InputError({.file = file_.string()},
                   fmt::format("is damaged at byte {}: {}, expected the record of a run as it was written",
                               record.at, problem));
}

}  // namespace forefeel
