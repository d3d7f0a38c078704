// Readers of .obj, .off, .stl and .ply surfaces; those of VTK are in surface_vtk.cpp. Polygons are cut into fans of
// triangles.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/meshing/surface_formats.hpp"

namespace forefeel {
namespace {

void read_obj_corner(Scanner& in, SurfaceBuilder& out, std::string_view corner) {
  std::int64_t index = 0;
  const auto known = static_cast<std::int64_t>(out.surface.nodes.size());
  if (!parse_integer(corner.substr(0, corner.find('/')), index) || index == 0 || index < -known ||
      index > 0x7fffffff)
    in.fail(fmt::format("'{:.40}' is no vertex of a face, expected a number from 1, or from -1 back to -{}",
                        corner, known));
  out.polygon.push_back(index > 0 ? index - 1 : known + index);
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  while (!(line = trimmed(line)).empty()) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    result.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return result;
}

Vec3 read_obj_vertex(Scanner& in, const std::vector<std::string_view>& word) {
  Vec3 node;
  if (word.size() < 4) in.fail(fmt::format("a vertex with {} coordinates, expected 3", word.size() - 1));
  for (std::size_t k = 0; k < 3; ++k)
    if (!parse_real(word[k + 1], node[static_cast<Eigen::Index>(k)]))
      in.fail(fmt::format("'{:.40}' is not a number, expected a coordinate", word[k + 1]));
  return node;
}

void read_obj(Scanner& in, SurfaceBuilder& out) {
  std::string_view line;
  while (in.line(line)) {
    const std::vector<std::string_view> word = words(line.substr(0, line.find('#')));
    if (word.empty()) continue;
    if (word[0] == "v") {
      out.surface.nodes.push_back(read_obj_vertex(in, word));
    } else if (word[0] == "f") {
      if (word.size() < 4)
        in.fail(fmt::format("a face with {} vertices, expected at least 3", word.size() - 1));
      for (std::size_t k = 1; k < word.size(); ++k) read_obj_corner(in, out, word[k]);
      out.end_polygon();
    }
  }
}

void read_off(Scanner& in, SurfaceBuilder& out) {
  in.comment('#');
  const std::string kind(in.token("OFF"));
  if (kind != "OFF" && kind != "COFF" && kind != "NOFF" && kind != "CNOFF")
    in.fail("is not an OFF file, expected OFF in the first line");
  const std::size_t nodes = in.count("a number of vertices", 6), faces = in.count("a number of faces", 2);
  in.integer("a number of edges");
  std::string_view rest;
  in.line(rest);
  out.surface.nodes.reserve(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const double x = in.real("x"), y = in.real("y"), z = in.real("z");
    out.surface.nodes.emplace_back(x, y, z);
    in.line(rest);  // colours and normals
  }
  for (std::size_t i = 0; i < faces; ++i) {
    const std::int64_t corners = in.integer("a number of corners", 1, most_corners);
    for (std::int64_t k = 0; k < corners; ++k)
      out.polygon.push_back(in.integer("a vertex number", 0, 0x7fffffff));
    out.end_polygon();
    in.line(rest);
  }
}

// STL repeats coordinates; equal ones are one node.
class Welder {
 public:
  explicit Welder(SurfaceBuilder& out) : out_(out) {}
  void corner(const Vec3& point) {
    const std::array<double, 3> key{point.x() + 0.0, point.y() + 0.0, point.z() + 0.0};  // -0 is 0
    if (key[0] != key[0] || key[1] != key[1] || key[2] != key[2]) {
      out_.surface.nodes.push_back(point);  // not finite: refused at the end, as in the other formats
      out_.polygon.push_back(static_cast<std::int64_t>(out_.surface.nodes.size()) - 1);
      return;
    }
    const auto [at, is_new] = known_.emplace(key, static_cast<std::int64_t>(out_.surface.nodes.size()));
    if (is_new) out_.surface.nodes.push_back(point);
    out_.polygon.push_back(at->second);
  }

 private:
  SurfaceBuilder& out_;
  std::map<std::array<double, 3>, std::int64_t> known_;
};

// "endfacet", written in one word or two.
std::string end_word(Scanner& in) {
  std::string word = lower_case(in.token("endfacet"));
  if (word == "end") word += lower_case(in.token("facet"));
  return word;
}

void read_stl_text(Scanner& in, SurfaceBuilder& out) {
  Welder weld(out);
  std::string_view line;
  in.line(line);  // solid NAME
  bool ended = false;
  while (!in.at_end()) {
    const std::string word = lower_case(in.token("facet"));
    if (word == "end" && lower_case(in.peek()) == "solid") {  // some programs write two words
      in.token("solid");
      ended = true;
      in.line(line);
    } else if (word == "endsolid") {
      ended = true;
      in.line(line);
    } else if (word == "solid") {
      in.line(line);
    } else if (word == "facet") {
      in.line(line);  // normal …
      if (lower_case(in.token("outer")) != "outer" || lower_case(in.token("loop")) != "loop")
        in.fail("expected 'outer loop'");
      std::string next;
      while ((next = lower_case(in.token("vertex"))) == "vertex") {
        const double x = in.real("x"), y = in.real("y"), z = in.real("z");
        weld.corner({x, y, z});
      }
      if (next == "end") next += lower_case(in.token("loop"));
      if (next != "endloop" || end_word(in) != "endfacet") in.fail("expected 'endloop' and 'endfacet'");
      if (out.polygon.size() < 3) in.fail("a facet with fewer than 3 vertices");
      out.end_polygon();
    } else {
      in.fail(fmt::format("'{:.40}' stands where facet or endsolid was expected", word));
    }
  }
  if (!ended) throw InputError({.file = in.name()}, "ends before endsolid, the file is cut short");
}

void read_stl(Scanner& in, SurfaceBuilder& out) {
  std::uint32_t n = 0;
  if (in.content().size() >= 84) std::memcpy(&n, in.content().data() + 80, 4);
  if (std::endian::native == std::endian::big) n = byte_swapped(n);
  // Binary files may begin with "solid", too; the length of the file decides.
  const bool binary =
      in.content().size() >= 84 && in.content().size() == 84 + 50 * static_cast<std::size_t>(n);
  if (!binary && lower_case(in.content().substr(0, 5)) == "solid") return read_stl_text(in, out);
  in.swap_bytes(std::endian::native == std::endian::big);
  in.bytes(84, "a header of 84 bytes");
  in.check_count(n, 50, "triangles");
  Welder weld(out);
  for (std::uint32_t i = 0; i < n; ++i) {
    in.bytes(12, "a normal");
    for (int k = 0; k < 3; ++k) {
      const float x = in.raw<float>("x"), y = in.raw<float>("y"), z = in.raw<float>("z");
      weld.corner({x, y, z});
    }
    in.bytes(2, "an attribute");
    out.end_polygon();
  }
}

class PlyReader {
 public:
  PlyReader(Scanner& in, SurfaceBuilder& out) : in_(in), out_(out) {}

  void read() {
    read_header();
    for (const Element& element : elements_)
      for (std::size_t i = 0; i < element.count; ++i) read_item(element);
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
      const std::vector<std::string_view> word = words(line);
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
    std::size_t least = 0;
    for (const Property& property : element.properties)
      least += !binary_ ? 1 : size_of(property.count_type.empty() ? property.type : property.count_type);
    if (least == 0 && element.count > 0)
      in_.fail(fmt::format("element {:.40} has no properties", element.name));
    if (least > 0) in_.check_count(element.count, least, element.name.c_str());
  }

  double value(const std::string& type) {
    if (!binary_) return in_.real("a number");
    const bool is_unsigned = type[0] == 'u';
    switch (size_of(type)) {
      case 1:
        return is_unsigned ? in_.raw<std::uint8_t>("a number") : in_.raw<std::int8_t>("a number");
      case 2:
        return is_unsigned ? in_.raw<std::uint16_t>("a number") : in_.raw<std::int16_t>("a number");
      case 4:
        if (type[0] == 'f') return in_.raw<float>("a number");
        return is_unsigned ? in_.raw<std::uint32_t>("a number") : in_.raw<std::int32_t>("a number");
      default:
        return in_.raw<double>("a number");
    }
  }

  [[noreturn]] void fail(const std::string& problem) {
    binary_ ? in_.fail_binary(problem) : in_.fail(problem);
  }

  void read_item(const Element& element) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    Vec3 node = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    for (const Property& property : element.properties) {
      if (property.count_type.empty()) {
        const double number = value(property.type);
        if (property.name == "x") node.x() = number;
        if (property.name == "y") node.y() = number;
        if (property.name == "z") node.z() = number;
        continue;
      }
      const double corners = value(property.count_type);
      if (!(corners >= 0) || corners > static_cast<double>(in_.remaining()))
        fail(fmt::format("a list of {} entries does not fit", corners));
      const bool wanted = is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
      for (std::size_t k = 0; k < static_cast<std::size_t>(corners); ++k) {
        const double index = value(property.type);
        if (!wanted) continue;
        if (!(index >= 0) || index > 0x7fffffff || index != std::floor(index))
          fail(fmt::format("{} is no vertex, expected a number from 0", index));
        out_.polygon.push_back(static_cast<std::int64_t>(index));
      }
    }
    if (is_vertex) out_.surface.nodes.push_back(node);
    if (is_face) out_.end_polygon();
  }

  Scanner& in_;
  SurfaceBuilder& out_;
  bool formatted_ = false, binary_ = false;
  std::vector<Element> elements_;
};

void check_surface(const Surface& surface, std::int64_t greatest, const std::string& where) {
  if (surface.triangles.empty()) throw InputError({.file = where}, "holds no triangles, expected a surface");
  if (greatest >= static_cast<std::int64_t>(surface.nodes.size()))
    throw InputError({.file = where}, fmt::format("a face names vertex {} (from 0), but there are {}",
                                                  greatest, surface.nodes.size()));
  for (std::size_t i = 0; i < surface.nodes.size(); ++i)
    if (!surface.nodes[i].allFinite())
      throw InputError({.file = where},
                       fmt::format("vertex {} (from 0) has a coordinate that is not finite", i));
}

}  // namespace

namespace {

// .vtk is a mesh or a surface: the line DATASET says which.
bool holds_polydata(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || std::filesystem::file_size(file, error) == 0)
    return false;
  Scanner in(read_start(file, 1024), file.string());
  std::string_view line;
  for (int i = 0; i < 6 && in.line(line); ++i)
    if (const std::string words = lower_case(trimmed(line)); words.starts_with("dataset"))
      return words.ends_with("polydata");
  return false;
}

}  // namespace

bool is_surface_file(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".obj" || extension == ".off" || extension == ".stl" || extension == ".ply" ||
         extension == ".vtp" || (extension == ".vtk" && holds_polydata(file));
}

Surface read_surface(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (extension != ".vtk" && !is_surface_file(file))
    throw InputError({.file = file.string()},
                     fmt::format("unknown kind of surface '{}', expected {}", extension, surface_extensions));
  Scanner in(read_file(file), file.string());
  SurfaceBuilder out;
  if (extension == ".obj")
    read_obj(in, out);
  else if (extension == ".off")
    read_off(in, out);
  else if (extension == ".stl")
    read_stl(in, out);
  else if (extension == ".vtk")
    read_polydata(std::move(in), out);
  else if (extension == ".vtp")
    read_vtp(std::move(in), out);
  else
    PlyReader(in, out).read();
  check_surface(out.surface, out.greatest, file.string());
  return std::move(out.surface);
}

}  // namespace forefeel
