#include "scheduling/render/input_format.hpp"

#include <fmt/format.h>

#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/instruction_set.hpp"
#include "geometry/states/energy_jet.hpp"

namespace forefeel {

namespace {

// One list of members serves writing and reading: `each` is called for every one of them.
template <class Each, class Header>
void for_each_member(Each&& each, Header& h) {
  each(h.made_by), each(h.real), each(h.frames), each(h.spare);
  auto& s = h.render.switching;
  each(s.rule), each(s.jnd_share), each(s.jnd_floor), each(s.frame), each(s.paper_interval);
  each(s.jump_speed), each(s.jump_length);
  auto& safety = h.render.safety;
  each(safety.force_limit), each(safety.slew_limit), each(safety.ramp_seconds), each(safety.stale_seconds);
  each(h.render.frame), each(h.render.viscosity);
  auto& p = h.render.passivity;
  each(p.mode), each(p.coupling), each(p.resolution), each(p.force_limit), each(p.recovery);
  auto& m = h.model;
  each(m.fit.kernel), each(m.fit.data), each(m.fit.neighbours), each(m.fit.select), each(m.fit.ridge);
  each(m.fit.length), each(m.method), each(m.update_travel), each(m.guess);
  if (m.fit.data == Data::jet)
    each(m.fit.tolerance), each(m.fit.floor);  // records of other runs are as before
  auto& space = h.space;
  each(space.spacing), each(space.box.low), each(space.box.high), each(space.merge_distance);
  auto& c = space.coverage;
  each(c.safe_spread), each(c.safe_cone_radius), each(c.safe_angle_deg), each(c.sparse_distance);
  each(c.gap_cone_radius), each(c.gap_angle_deg);
}

struct Write {
  Packer& out;
  void operator()(const std::string& text) { out.add(std::string_view(text)); }
  void operator()(bool flag) { out.add(std::uint8_t{flag}); }
  template <Number Value>
  void operator()(const Value& value) {
    out.add(value);
  }
  void operator()(const Vec3& x) { out.add(x); }
  void operator()(const Mat3& m) {
    for (int i = 0; i < 3; ++i) out.add(Vec3(m.row(i)));
  }
  void operator()(const Viscosity& branches) {
    out.add(std::uint64_t{branches.size()});
    for (const MaxwellBranch& branch : branches) out.add(branch.share), out.add(branch.time);
  }
};

struct Read {
  Unpacker& in;
  void operator()(std::string& text) { text = in.text(); }
  void operator()(bool& flag) { flag = in.number<std::uint8_t>() != 0; }
  template <Number Value>
  void operator()(Value& value) {
    value = in.number<Value>();
  }
  void operator()(Vec3& x) { x = in.vector(); }
  void operator()(Mat3& m) {
    for (int i = 0; i < 3; ++i) m.row(i) = in.vector();
  }
  void operator()(Viscosity& branches) {
    branches.clear();
    for (auto left = in.number<std::uint64_t>(); left > 0; --left) {
      const double share = in.number<double>();
      branches.push_back({.share = share, .time = in.number<double>()});
    }
  }
};

// FNV-1a, 64 bits.
std::uint64_t digest(std::span<const char> bytes) {
  std::uint64_t value = 0xcbf29ce484222325ULL;
  for (const char byte : bytes) value = (value ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
  return value;
}

}  // namespace

std::string inputs_made_by(std::string_view program) {
  return fmt::format("{}, {}", program, name(instruction_set_in_use()));
}

void pack(Packer& out, const InputHeader& header) {
  Packer content;
  for_each_member(Write{content}, header);
  const Bytes bytes = content.take();
  out.add_raw(bytes);
  out.add(digest(bytes));
}

InputHeader unpack_header(Unpacker& in) {
  const Bytes all = in.rest();
  const std::size_t size = all.size() < sizeof(std::uint64_t) ? 0 : all.size() - sizeof(std::uint64_t);
  const Bytes bytes(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(size));
  Unpacker last(Bytes(all.begin() + static_cast<std::ptrdiff_t>(size), all.end()));
  if (last.number<std::uint64_t>() != digest(bytes)) throw MalformedMessage("the header is damaged");
  Unpacker content(bytes);
  InputHeader header;
  for_each_member(Read{content}, header);
  content.expect_end();
  return header;
}

void pack(Packer& out, const ModelInput& model) {
  out.add(model.hip);
  out.add(model.states);
  out.add(model.serial);
  out.add(std::uint8_t{model.published});
}

ModelInput unpack_model(Unpacker& in) {
  ModelInput model;
  model.hip = in.vector();
  model.states = in.number<std::uint32_t>();
  model.serial = in.number<std::uint64_t>();
  model.published = in.number<std::uint8_t>() != 0;
  in.expect_end();
  return model;
}

void pack(Packer& out, const FrameInput& f) {
  out.add(f.frame);
  out.add(f.known);
  out.add(f.model);
  out.add(static_cast<std::uint8_t>((f.ended ? 1 : 0) | (f.held ? 2 : 0)));
  for (const double t : {f.started, f.now, f.beat}) out.add(t);
  for (const Vec3& v : {f.at, f.rendered, f.sent}) out.add(v);
}

FrameInput unpack_frame(Unpacker& in) {
  FrameInput f;
  f.frame = in.number<std::uint32_t>();
  f.known = in.number<std::uint32_t>();
  f.model = in.number<std::uint64_t>();
  const auto flags = in.number<std::uint8_t>();
  if (flags > 3) throw MalformedMessage("a frame has unknown flags");
  f.ended = (flags & 1) != 0;
  f.held = (flags & 2) != 0;
  for (double* t : {&f.started, &f.now, &f.beat}) *t = in.number<double>();
  for (Vec3* v : {&f.at, &f.rendered, &f.sent}) *v = in.vector();
  in.expect_end();
  return f;
}

void pack_record(Packer& out, InputKind kind, const Bytes& content) {
  out.add(kind);
  out.add(static_cast<std::uint32_t>(content.size()));
  out.add_raw(content);
}

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
