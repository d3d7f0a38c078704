#pragma once
// The numbers of a Gmsh file, text or binary, and its types of elements. For mesh_gmsh.cpp alone.

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <utility>

#include "geometry/common/scanner.hpp"

namespace forefeel {

// Nodes of an element type and the dimension of its entity; {0, 0} for an unknown type.
struct GmshElement {
  int nodes, dimension;
};
GmshElement gmsh_element(std::int64_t type);
const char* gmsh_element_name(std::int64_t type);  // of a volume element, in the plural
constexpr int second_order_nodes = 10;             // of the only volume elements with so many, tetrahedra

class GmshScanner {
 protected:
  explicit GmshScanner(Scanner in) : in_(std::move(in)) {}

  void end_section(const std::string& section) {
    const auto word = in_.token("the end of a section");
    if (word != "$End" + section)
      in_.fail(fmt::format("'{:.40}' stands where $End{} was expected", word, section));
  }

  // Binary data begin on the byte after the line that announces them.
  void next_line() {
    std::string_view rest;
    if (!in_.line(rest) || !trimmed(rest).empty()) in_.fail("text stands where binary data were expected");
  }

  std::int64_t whole(const char* expected) {
    return binary_ ? in_.raw<std::int32_t>(expected) : in_.integer(expected);
  }
  std::int64_t size(const char* expected) {  // size_t of format 4.1
    if (!binary_) return in_.integer(expected);
    const auto value = in_.raw<std::uint64_t>(expected);
    if (value > (std::uint64_t{1} << 62))
      in_.fail_binary(fmt::format("{} is out of range, expected {}", value, expected));
    return static_cast<std::int64_t>(value);
  }
  double real(const char* expected) { return binary_ ? in_.raw<double>(expected) : in_.real(expected); }
  std::size_t size_count(const char* expected, std::size_t bytes_text, std::size_t bytes_binary) {
    if (!binary_) return in_.count(expected, bytes_text);
    const auto value = static_cast<std::uint64_t>(size(expected));
    in_.check_count(value, bytes_binary, expected);
    return value;
  }
  [[noreturn]] void fail(const std::string& problem) {
    binary_ ? in_.fail_binary(problem) : in_.fail(problem);
  }

  Scanner in_;
  bool binary_ = false;
};

}  // namespace forefeel
