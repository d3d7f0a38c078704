#pragma once
// Packs values into bytes, for files of this machine and for messages between processes of the same build on machines
// of the same kind. Numbers are copied as they are in memory; lists and texts follow their length (64 bits). An
// Unpacker checks every length and never reads beyond the end.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

using Bytes = std::vector<char>;

// Thrown if the content of a message does not match its kind.
class MalformedMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <class Value>
concept Number = std::is_arithmetic_v<Value> || std::is_enum_v<Value>;

class Packer {
 public:
  template <Number Value>
  void add(Value value) {
    append(&value, sizeof value);
  }
  void add(const Vec3& x) { append(x.data(), 3 * sizeof(double)); }
  template <class Value>  // numbers, or arrays of them
  void add(const std::vector<Value>& values) {
    add(std::uint64_t{values.size()});
    append(values.data(), values.size() * sizeof(Value));
  }
  void add(std::string_view text) {
    add(std::uint64_t{text.size()});
    append(text.data(), text.size());
  }
  void add_raw(std::span<const char> bytes) { append(bytes.data(), bytes.size()); }  // without their length
  Bytes take() { return std::move(bytes_); }

 private:
  void append(const void* from, std::size_t size) {
    const auto* begin = static_cast<const char*>(from);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  Bytes bytes_;
};

// All functions throw MalformedMessage if the bytes end before the value does.
class Unpacker {
 public:
  explicit Unpacker(Bytes bytes) : bytes_(std::move(bytes)) {}

  template <Number Value>
  Value number() {
    Value value;
    std::memcpy(&value, next(sizeof value), sizeof value);
    return value;
  }
  Vec3 vector() {
    Vec3 x;
    std::memcpy(x.data(), next(3 * sizeof(double)), 3 * sizeof(double));
    return x;
  }
  template <class Value = double>
  std::vector<Value> values() {
    const std::uint64_t count = number<std::uint64_t>();
    if (count > left() / sizeof(Value)) throw MalformedMessage("a list is longer than its message");
    std::vector<Value> values(count);
    if (count > 0)
      std::memcpy(static_cast<void*>(values.data()), next(count * sizeof(Value)), count * sizeof(Value));
    return values;
  }
  std::string text() {
    const std::uint64_t count = number<std::uint64_t>();
    if (count > left()) throw MalformedMessage("a text is longer than its message");
    const char* begin = next(count);
    return {begin, begin + count};
  }
  Bytes rest() {
    const std::size_t count = left();
    const char* begin = next(count);
    return {begin, begin + count};
  }
  std::size_t left() const { return bytes_.size() - at_; }
  void expect_end() const {
    if (left() > 0) throw MalformedMessage("a message is longer than its content");
  }

 private:
  const char* next(std::size_t size) {
    if (size > left()) throw MalformedMessage("a message ends too early");
    at_ += size;
    return bytes_.data() + (at_ - size);
  }
  Bytes bytes_;
  std::size_t at_ = 0;
};

}  // namespace forefeel
