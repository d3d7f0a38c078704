#include "geometry/meshing/surface_ply.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

class PlyReader {
 public:
  PlyReader(Scanner& in, SurfaceBuilder& out) : in_(in), out_(out) {}

  void read() {
    read_header();
    for (const Element& element : elements_)
      for (std::size_t i = 0; i < element.count; ++i) read_item(element);
    if (!binary_) return out_.say_rest(in_, "the last element");
    if (in_.remaining() > 0)
      out_.surface.remarks.push_back(
          fmt::format("{} bytes behind the last element are left out", in_.remaining()));
  }

 private:
  struct Property {
    std::string name, type, count_type;  // count_type empty: a single value
  };
  struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
  };

  static std::size_t size_of(const std::string& type) {
    static const std::map<std::string, std::size_t> sizes{
        {"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
        {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
        {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
    const auto found = sizes.find(type);
    return found == sizes.end() ? 0 : found->second;
  }

  void read_header() {
    std::string_view line;
    if (!in_.line(line) || trimmed(line) != "ply")
      in_.fail("is not a PLY file, expected 'ply' in the first line");
    for (;;) {
      if (!in_.line(line)) in_.fail("the file ends before end_header");
      const std::vector<std::string_view> word = words_of(line);
      if (word.empty() || word[0] == "comment" || word[0] == "obj_info") continue;
      if (word[0] == "end_header") break;
      if (word[0] == "format" && word.size() >= 2)
        read_format(std::string(word[1]));
      else if (word[0] == "element" && word.size() == 3)
        read_element(word);
      else if (word[0] == "property" && !elements_.empty())
        read_property(word);
      else
        in_.fail(fmt::format("'{:.40}' stands where element, property or end_header was expected", line));
    }
    if (!formatted_) in_.fail("the header has no format");
    for (const Element& element : elements_) check_element(element);
  }

  void read_format(const std::string& format) {
    if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
      in_.fail(fmt::format("format '{:.40}' is unknown, expected ascii or binary_…_endian", format));
    formatted_ = true;
    binary_ = format != "ascii";
    in_.swap_bytes(binary_ && (format == "binary_big_endian") != (std::endian::native == std::endian::big));
  }

  void read_element(const std::vector<std::string_view>& word) {
    std::int64_t n = 0;
    if (!parse_integer(word[2], n) || n < 0)
      in_.fail(fmt::format("'{:.40}' is no count, expected a whole number", word[2]));
    elements_.push_back({std::string(word[1]), static_cast<std::size_t>(n), {}});
  }

  void read_property(const std::vector<std::string_view>& word) {
    const bool list = word.size() == 5 && word[1] == "list";
    if (!list && word.size() != 3) in_.fail("a property has a name and a type, or list and two types");
    Property property{std::string(word.back()), std::string(word[word.size() - 2]),
                      list ? std::string(word[2]) : std::string()};
    if (size_of(property.type) == 0 || (list && size_of(property.count_type) == 0))
      in_.fail("the type of a property is unknown");
    elements_.back().properties.push_back(std::move(property));
  }

  // An announced count must fit into the file, whatever its items hold.
  void check_element(const Element& element) {
    if (element.name == "tristrips" && element.count > 0)
      in_.fail("triangle strips are not read, expected faces (element face)");
    std::size_t least = 0;
    for (const Property& property : element.properties)
      least += !binary_ ? 1 : size_of(property.count_type.empty() ? property.type : property.count_type);
    if (least == 0 && element.count > 0)
      in_.fail(fmt::format("element {:.40} has no properties", element.name));
    if (least > 0) in_.check_count(element.count, least, element.name.c_str());
  }

  double value(const std::string& type) {
    if (!binary_) return text_value();
    const bool is_unsigned = type[0] == 'u';
    switch (size_of(type)) {
      case 1:
        return is_unsigned ? in_.raw<std::uint8_t>("a number") : in_.raw<std::int8_t>("a number");
      case 2:
        return is_unsigned ? in_.raw<std::uint16_t>("a number") : in_.raw<std::int16_t>("a number");
      case 4:
        if (type[0] == 'f') return in_.raw<float>("a number");
        if (is_unsigned) return in_.raw<std::uint32_t>("a number");  // no common type: it would be unsigned
        return in_.raw<std::int32_t>("a number");
      default:
        return in_.raw<double>("a number");
    }
  }

  // Items of text stand on one line each: a wrong count would else take numbers of other items.
  double text_value() {
    const double number = in_.real("a number");
    const std::size_t line = in_.where().line;
    if (line_ == 0) line_ = line;
    if (line != line_) fail_item("fewer");
    return number;
  }

  [[noreturn]] void fail_item(const char* more_or_fewer) {
    throw InputError({.file = in_.name(), .line = line_},
                     fmt::format("{} numbers than one {:.40} has, of which the header announces {}, expected "
                                 "one on each line",
                                 more_or_fewer, item_->name, item_->count));
  }

  [[noreturn]] void fail(const std::string& problem) {
    binary_ ? in_.fail_binary(problem) : in_.fail(problem);
  }

  void read_item(const Element& element) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    item_ = &element;
    line_ = 0;
    Vec3 node = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    for (const Property& property : element.properties) {
      if (property.count_type.empty()) {
        const double number = value(property.type);
        if (property.name == "x") node.x() = number;
        if (property.name == "y") node.y() = number;
        if (property.name == "z") node.z() = number;
        continue;
      }
      const double entries = value(property.count_type);
      if (!(entries >= 0) || entries > static_cast<double>(in_.remaining()))
        fail(fmt::format("a list of {} entries does not fit", entries));
      const bool corners = is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
      for (std::size_t k = 0; k < static_cast<std::size_t>(entries); ++k) {
        const double entry = value(property.type);
        if (corners) out_.polygon.push_back(vertex(entry));
      }
    }
    if (is_vertex) out_.surface.nodes.push_back(node);
    if (is_face) out_.end_polygon(line_);
    std::string_view rest;
    if (!binary_ && in_.line(rest) && !trimmed(rest).empty()) fail_item("more");
  }

  std::int64_t vertex(double index) {
    if (!(index >= 0) || index > 0x7fffffff || index != std::floor(index))
      fail(fmt::format("{} is no vertex, expected a number from 0", index));
    return static_cast<std::int64_t>(index);
  }

  Scanner& in_;
  SurfaceBuilder& out_;
  bool formatted_ = false, binary_ = false;
  const Element* item_ = nullptr;  // being read
  std::size_t line_ = 0;           // of its text; 0: none yet
  std::vector<Element> elements_;
};

}  // namespace

void read_ply(Scanner& in, SurfaceBuilder& out) {
  PlyReader(in, out).read();
}

}  // namespace forefeel
