#include "scheduling/render/input_format.hpp"

#include <fmt/format.h>

#include <span>
#include <type_traits>

#include "geometry/common/instruction_set.hpp"

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

}  // namespace forefeel
