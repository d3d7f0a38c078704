// Readers of surfaces: .obj .off .stl .ply, and legacy .vtk with DATASET POLYDATA. Polygons are cut into
// triangles in their plane.
//
// CGAL's readers of polygon soups (5.5) are not used: of .obj they drop faces whose corners are separated by tabs and
// refuse files with lines, of .ply they take indices beyond the vertices and end in a crash where coordinates are
// whole numbers, of .stl they refuse upper case; none says the line.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/vtk_legacy.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/meshing/surface_ply.hpp"

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

Vec3 read_obj_vertex(Scanner& in, const std::vector<std::string_view>& word) {
  Vec3 node;
  if (word.size() < 4) in.fail(fmt::format("a vertex with {} coordinates, expected 3", word.size() - 1));
  for (unsigned k = 0; k < 3; ++k)
    if (!parse_real(word[k + 1], node[k]) || !std::isfinite(node[k]))
      in.fail(fmt::format("'{:.40}' is not a number, expected a coordinate", word[k + 1]));
  return node;
}

void read_obj(Scanner& in, SurfaceBuilder& out) {
  out.first = 1;
  std::string_view line;
  std::string joined;
  while (in.line(line)) {
    for (joined.clear(); trimmed(line).ends_with('\\');) {  // goes on in the next line
      joined += trimmed(line).substr(0, trimmed(line).size() - 1);
      joined += ' ';
      if (!in.line(line)) line = {};
    }
    joined += line;
    const std::vector<std::string_view> word = words_of(std::string_view(joined).substr(0, joined.find('#')));
    if (word.empty()) continue;
    if (word[0] == "v") {
      out.surface.nodes.push_back(read_obj_vertex(in, word));
    } else if (word[0] == "f") {
      if (word.size() < 4)
        in.fail(fmt::format("a face with {} vertices, expected at least 3", word.size() - 1));
      for (std::size_t k = 1; k < word.size(); ++k) read_obj_corner(in, out, word[k]);
      out.end_polygon(in.where().line);
    }
  }
}

void read_off(Scanner& in, SurfaceBuilder& out) {
  in.comment('#');
  // The keyword may be missing. ST, C and N: texture, colour and normal follow the position of a vertex.
  std::int64_t number = 0;
  if (const std::string first(in.peek()); !parse_integer(first, number)) {
    std::string kind = lower_case(in.token("OFF"));
    for (const std::string_view before : {"st", "c", "n"})
      if (kind.starts_with(before)) kind.erase(0, before.size());
    if (kind != "off")
      in.fail(
          "is not an OFF file of positions in space, expected OFF, COFF, NOFF or STOFF in the first line");
    if (lower_case(in.peek()) == "binary") in.fail("is a binary OFF file, expected one of text");
  }
  const std::size_t nodes = in.count("a number of vertices", 6), faces = in.count("a number of faces", 2);
  std::string_view rest;
  in.line(rest);  // the number of edges, which some leave out
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
    out.end_polygon(in.where().line);
    in.line(rest);
  }
  out.say_rest(in, "the last face");
}

// A corner with coordinates of its own; equal ones become one node at the end.
void add_corner(SurfaceBuilder& out, const Vec3& point) {
  out.polygon.push_back(static_cast<std::int64_t>(out.surface.nodes.size()));
  out.surface.nodes.push_back(point);
}

// "endfacet", written in one word or two.
std::string end_word(Scanner& in) {
  std::string word = lower_case(in.token("endfacet"));
  if (word == "end") word += lower_case(in.token("facet"));
  return word;
}

void read_stl_text(Scanner& in, SurfaceBuilder& out) {
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
        add_corner(out, {x, y, z});
      }
      if (next == "end") next += lower_case(in.token("loop"));
      if (next != "endloop" || end_word(in) != "endfacet") in.fail("expected 'endloop' and 'endfacet'");
      if (out.polygon.size() < 3) in.fail("a facet with fewer than 3 vertices");
      out.end_polygon(in.where().line);
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
  // Binary files may begin with "solid", too: the length of the file decides, else whether it is text.
  const std::size_t bytes = 84 + 50 * static_cast<std::size_t>(n);
  const std::string start = lower_case(trimmed(in.content().substr(0, 1024)));
  if (in.content().size() != bytes && start.starts_with("solid") && start.find('\0') == std::string::npos)
    return read_stl_text(in, out);
  in.swap_bytes(std::endian::native == std::endian::big);
  in.bytes(84, "a header of 84 bytes");
  in.check_count(n, 50, "triangles");
  for (std::uint32_t i = 0; i < n; ++i) {
    in.bytes(12, "a normal");
    for (int k = 0; k < 3; ++k) {
      const float x = in.raw<float>("x"), y = in.raw<float>("y"), z = in.raw<float>("z");
      add_corner(out, {x, y, z});
    }
    in.bytes(2, "an attribute");
    out.end_polygon();
  }
  if (in.remaining() >= 50)
    in.fail_binary(fmt::format("{} triangles are announced, and {} bytes follow them, expected none", n,
                               in.remaining()));
  if (in.remaining() > 0)
    out.surface.remarks.push_back(
        fmt::format("{} bytes behind the last triangle are left out", in.remaining()));
}

// Polygons and triangle strips of alternating orientation; points and lines are passed over.
void read_polydata(Scanner in, SurfaceBuilder& out) {
  const std::string where = in.name();
  VtkLegacyFile file = read_vtk_file(std::move(in));
  if (!file.polydata)
    throw InputError({.file = where}, "DATASET UNSTRUCTURED_GRID is a mesh, expected POLYDATA");
  out.surface.nodes = std::move(file.points);
  const auto known = static_cast<std::int64_t>(out.surface.nodes.size());
  const auto corner = [&](std::int64_t point) {
    if (point < 0 || point >= known)
      throw InputError({.file = where},
                       fmt::format("a face names point {}, expected 0 to {}", point, known - 1));
    out.polygon.push_back(point);
  };
  const auto polygon = [&](std::span<const std::int64_t> face) {
    if (face.size() > static_cast<std::size_t>(most_corners))
      throw InputError({.file = where},
                       fmt::format("a face with {} corners, expected at most {}", face.size(), most_corners));
    for (const std::int64_t point : face) corner(point);
    out.end_polygon();
  };
  const auto strip = [&](std::span<const std::int64_t> face) {
    for (std::size_t i = 0; i + 2 < face.size(); ++i) {
      const bool turned = i % 2 == 1;
      corner(face[turned ? i + 1 : i]), corner(face[turned ? i : i + 1]), corner(face[i + 2]);
      out.end_polygon();
    }
  };
  const auto for_each = [&](const char* kind, auto&& add) {
    const VtkCells& of = file.cells[kind];
    for (std::size_t i = 0; i < of.size(); ++i)
      add(std::span(of.connectivity).subspan(of.offsets[i], of.offsets[i + 1] - of.offsets[i]));
  };
  for_each("polygons", polygon);
  for_each("triangle_strips", strip);
}

void check_nodes(const Surface& surface, const std::string& where) {
  for (std::size_t i = 0; i < surface.nodes.size(); ++i)
    if (!surface.nodes[i].allFinite())
      throw InputError({.file = where},
                       fmt::format("vertex {} (from 0) has a coordinate that is not finite", i));
}

// Remarks on faces of one kind: how many there are, and where the first stands.
struct FaceRemark {
  std::string what;
  std::size_t count = 0, first = 0;
  void add(std::size_t face) {
    if (count++ == 0) first = face;
  }
  void put(const std::vector<std::size_t>& lines, std::vector<std::string>& to) const {
    if (count == 0) return;
    const std::string place =
        lines[first] > 0 ? fmt::format("line {}", lines[first]) : fmt::format("face {} (from 0)", first);
    to.push_back(count == 1 ? fmt::format("{}: a face {}", place, what)
                            : fmt::format("{}: a face {}, the first of {}", place, what, count));
  }
};

void cut_polygons(SurfaceBuilder& from, const std::string& where) {
  constexpr double most_off_plane = 0.02;  // of the size of a polygon
  Surface& surface = from.surface;
  const auto known = static_cast<std::int64_t>(surface.nodes.size());
  FaceRemark crossing{"crosses itself, and its triangles are a guess"};
  FaceRemark bent{
      "of more than four corners, or concave, is not planar, and its triangles are one choice of several"};
  std::vector<NodeIndex> polygon;
  for (std::size_t face = 0, begin = 0; face < from.ends.size(); begin = from.ends[face++]) {
    polygon.clear();
    for (std::size_t k = begin; k < from.ends[face]; ++k) {
      if (from.corners[k] >= known)
        throw InputError({.file = where, .line = from.lines[face]},
                         fmt::format("a face names vertex {} (from {}), but there are {}",
                                     from.corners[k] + from.first, from.first, known));
      polygon.push_back(static_cast<NodeIndex>(from.corners[k]));
    }
    const PolygonCut cut = cut_polygon(surface.nodes, polygon, surface.triangles);
    if (cut.crosses) crossing.add(face);
    if (cut.off_plane > most_off_plane && (polygon.size() > 4 || !cut.convex)) bent.add(face);
  }
  if (surface.triangles.empty()) throw InputError({.file = where}, "holds no triangles, expected a surface");
  crossing.put(from.lines, surface.remarks);
  bent.put(from.lines, surface.remarks);
}

// Points that coincide exactly become one, the first of them: STL, and many files of VTK, give each triangle points of
// its own.
void weld(Surface& surface) {
  const std::vector<Vec3>& nodes = surface.nodes;
  const auto place = [&](std::size_t i) {
    return std::array{nodes[i].x() + 0.0, nodes[i].y() + 0.0, nodes[i].z() + 0.0};  // -0 is 0
  };
  std::vector<std::size_t> order(nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, place);
  std::vector<std::size_t> first(nodes.size());  // of the same place
  for (std::size_t k = 0; k < order.size(); ++k)
    first[order[k]] = k > 0 && place(order[k]) == place(order[k - 1]) ? first[order[k - 1]] : order[k];
  std::vector<NodeIndex> number(nodes.size());
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    number[i] = first[i] == i ? static_cast<NodeIndex>(kept.size()) : number[first[i]];
    if (first[i] == i) kept.push_back(nodes[i]);
  }
  for (Triangle& triangle : surface.triangles)
    for (NodeIndex& node : triangle) node = number[node];
  surface.nodes = std::move(kept);
}

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
         (extension == ".vtk" && holds_polydata(file));
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
  else
    read_ply(in, out);
  check_nodes(out.surface, file.string());
  cut_polygons(out, file.string());
  weld(out.surface);
  return std::move(out.surface);
}

}  // namespace forefeel
