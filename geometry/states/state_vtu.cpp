// States as a VTU point cloud: inline binary data (base64, UInt64 headers, little-endian). Values that no state has are
// left out. If only some states have a value, the others get NaN.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "geometry/common/output_file.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {
namespace {

class Base64 {
 public:
  explicit Base64(OutputFile& output) : output_(output) {}
  void bytes(const void* data, std::size_t n) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < n; ++i) {
      word_ = word_ << 8 | at[i];
      if (++held_ == 3) put(4);
    }
  }
  void finish() {
    if (held_ != 0) {
      const int letters = held_ + 1;
      word_ <<= 8 * (3 - held_);
      put(letters);
    }
    output_.write(text_);
    text_.clear();
  }

 private:
  void put(int letters) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int k = 0; k < 4; ++k) text_ += k < letters ? alphabet[word_ >> (18 - 6 * k) & 63] : '=';
    word_ = 0, held_ = 0;
    if (text_.size() > (1u << 20)) output_.write(text_), text_.clear();
  }
  OutputFile& output_;
  std::string text_;
  std::uint32_t word_ = 0;
  int held_ = 0;
};

class VtuWriter {
 public:
  explicit VtuWriter(const std::filesystem::path& file) : output_(file) {}

  // value(state, k): component k of the array's value for that state.
  template <class T, class Value>
  void array(std::string_view type, std::string_view name, int width, std::span<const State> states,
             Value&& value) {
    output_.write(
        fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n", type,
                    name, width));
    Base64 data(output_);
    const std::uint64_t size = sizeof(T) * states.size() * static_cast<std::size_t>(width);
    data.bytes(&size, sizeof size);
    for (const State& state : states)
      for (int k = 0; k < width; ++k) {
        const T item = static_cast<T>(value(state, k));
        data.bytes(&item, sizeof item);
      }
    data.finish();
    output_.write("\n</DataArray>\n");
  }
  // Left out if no state has a value. A state without one has NaN.
  template <class Value>
  void known(std::string_view name, int width, std::span<const State> states, Value&& value) {
    const bool any = std::ranges::any_of(states, [&](const State& state) {
      for (int k = 0; k < width; ++k)
        if (!std::isnan(value(state, k))) return true;
      return false;
    });
    if (any) array<double>("Float64", name, width, states, value);
  }
  void text(std::string_view line) { output_.write(line); }
  void commit() { output_.commit(); }

 private:
  OutputFile output_;
};

}  // namespace

void write_states_vtu(const std::filesystem::path& file, std::span<const State> states) {
  VtuWriter out(file);
  out.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n");
  const bool force = std::ranges::any_of(states, [](const State& s) { return !s.force.hasNaN(); });
  out.text(fmt::format("<Piece NumberOfPoints=\"{0}\" NumberOfCells=\"{0}\">\n<PointData{1}>\n",
                       states.size(), force ? " Vectors=\"force\"" : ""));
  out.known("force", 3, states, [](const State& s, int k) { return s.force[k]; });
  out.known("stiffness", 9, states, [](const State& s, int k) { return s.stiffness(k / 3, k % 3); });
  out.known("energy", 1, states, [](const State& s, int) { return s.energy; });
  out.known("spacing", 1, states, [](const State& s, int) { return s.spacing; });
  out.known("residual", 1, states, [](const State& s, int) { return s.solve.residual; });
  out.known("seconds", 1, states, [](const State& s, int) { return s.solve.seconds; });
  out.known("min_jacobian", 1, states, [](const State& s, int) { return s.solve.min_jacobian; });
  out.known("parent", 3, states, [](const State& s, int k) { return s.solve.parent[k]; });
  out.array<std::int32_t>("Int32", "iterations", 1, states,
                          [](const State& s, int) { return s.solve.iterations; });
  out.array<std::uint8_t>("UInt8", "status", 1, states,
                          [](const State& s, int) { return static_cast<int>(outcome(s)); });
  out.array<std::uint8_t>("UInt8", "multivalued", 1, states,
                          [](const State& s, int) { return s.solve.multivalued; });
  out.text("</PointData>\n<Points>\n");
  out.array<double>("Float64", "position", 3, states, [](const State& s, int k) { return s.at[k]; });
  out.text("</Points>\n<Cells>\n");
  std::int64_t next = 0, end = 0;
  out.array<std::int64_t>("Int64", "connectivity", 1, states, [&](const State&, int) { return next++; });
  out.array<std::int64_t>("Int64", "offsets", 1, states, [&](const State&, int) { return ++end; });
  out.array<std::uint8_t>("UInt8", "types", 1, states, [](const State&, int) { return 1; });  // VTK_VERTEX
  out.text("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
  out.commit();
}

}  // namespace forefeel
