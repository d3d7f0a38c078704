// Legacy .vtk, DATASET UNSTRUCTURED_GRID: versions up to 4.2 (CELLS n size) and 5.1 (OFFSETS, CONNECTIVITY),
// ASCII and BINARY (big-endian). Points, lines and faces among the cells are passed over; other volume cells
// are refused.

#include <fmt/format.h>

#include <map>

#include "geometry/common/error.hpp"
#include "geometry/mesh/mesh_formats.hpp"

namespace forefeel {

void add_vtk_cell(TetMesh& mesh, std::int64_t type, std::span<const std::int64_t> nodes,
                  const std::string& where) {
  constexpr std::int64_t tetra = 10;
  static const std::set<std::int64_t> flat{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 36};
  if (flat.contains(type)) return;
  if (type != tetra)
    throw InputError({.file = where},
                     fmt::format("cells of VTK type {} are not read, expected linear tetrahedra (10)", type));
  if (nodes.size() != 4)
    throw InputError({.file = where}, fmt::format("a tetrahedron with {} nodes, expected 4", nodes.size()));
  Tet tet;
  for (std::size_t k = 0; k < 4; ++k) {
    if (nodes[k] < 0 || nodes[k] >= static_cast<std::int64_t>(mesh.nodes.size()))
      throw InputError({.file = where}, fmt::format("a cell names point {}, expected 0 to {}", nodes[k],
                                                    static_cast<std::int64_t>(mesh.nodes.size()) - 1));
    tet[k] = static_cast<NodeIndex>(nodes[k]);
  }
  mesh.tets.push_back(tet);
}

namespace {

class LegacyReader {
 public:
  explicit LegacyReader(Scanner in) : in_(std::move(in)) {}

  TetMesh read() {
    read_header();
    while (!in_.at_end()) {
      const std::string keyword = lower_case(in_.token("a keyword"));
      if (keyword == "points")
        read_points();
      else if (keyword == "cells")
        read_cells();
      else if (keyword == "cell_types")
        read_types();
      else if (keyword == "field")
        skip_field();
      else if (keyword == "metadata")
        skip_metadata();
      else if (keyword == "point_data" || keyword == "cell_data")
        break;  // the rest of the file is not needed
      else
        in_.fail(fmt::format("keyword '{:.40}' is unknown, expected POINTS, CELLS or CELL_TYPES", keyword));
    }
    if (!seen_points_ || !seen_cells_ || !seen_types_)
      throw InputError({.file = in_.name()},
                       fmt::format("ends without {}, the file is cut short", !seen_points_  ? "POINTS"
                                                                             : !seen_cells_ ? "CELLS"
                                                                                            : "CELL_TYPES"));
    if (types_.size() + 1 != offsets_.size())
      throw InputError({.file = in_.name()},
                       fmt::format("{} cells, but {} cell types", offsets_.size() - 1, types_.size()));
    for (std::size_t i = 0; i < types_.size(); ++i)
      add_vtk_cell(mesh_, types_[i],
                   std::span(connectivity_).subspan(offsets_[i], offsets_[i + 1] - offsets_[i]), in_.name());
    return std::move(mesh_);
  }

 private:
  void read_header() {
    std::string_view line;
    if (!in_.line(line) || !lower_case(line).starts_with("# vtk datafile version"))
      in_.fail("is not a legacy VTK file, expected '# vtk DataFile Version'");
    if (!in_.line(line)) in_.fail("the file ends where a title was expected");
    const std::string mode = lower_case(in_.token("ASCII or BINARY"));
    if (mode != "ascii" && mode != "binary")
      in_.fail(fmt::format("'{:.40}' stands where ASCII or BINARY was expected", mode));
    binary_ = mode == "binary";
    in_.swap_bytes(binary_ && std::endian::native == std::endian::little);
    if (lower_case(in_.token("DATASET")) != "dataset") in_.fail("expected DATASET");
    const std::string kind = lower_case(in_.token("UNSTRUCTURED_GRID"));
    if (kind != "unstructured_grid")
      in_.fail(fmt::format("DATASET {:.40} is not read, expected UNSTRUCTURED_GRID", kind));
  }

  static std::size_t size_of(const std::string& type) {
    static const std::map<std::string, std::size_t> sizes{
        {"char", 1},          {"unsigned_char", 1}, {"short", 2},         {"unsigned_short", 2},
        {"int", 4},           {"unsigned_int", 4},  {"long", 8},          {"unsigned_long", 8},
        {"float", 4},         {"double", 8},        {"vtkidtype", 4},     {"vtktypeint64", 8},
        {"vtktypeuint64", 8}, {"vtktypeint32", 4},  {"vtktypeuint32", 4}, {"vtktypeint8", 1},
        {"vtktypeuint8", 1},  {"vtktypeint16", 2},  {"vtktypeuint16", 2}};
    const auto found = sizes.find(type);
    return found == sizes.end() ? 0 : found->second;
  }

  std::string data_type() {
    std::string type = lower_case(in_.token("a data type"));
    if (size_of(type) == 0) in_.fail(fmt::format("data type '{:.40}' is unknown", type));
    return type;
  }

  void next_line() {
    std::string_view rest;
    if (binary_ && (!in_.line(rest) || !trimmed(rest).empty()))
      in_.fail("text stands where binary data were expected");
  }

  double real(const std::string& type) {
    if (!binary_) return in_.real("a coordinate");
    if (type == "float") return in_.raw<float>("a coordinate");
    if (type == "double") return in_.raw<double>("a coordinate");
    return static_cast<double>(whole(type, "a coordinate"));
  }
  std::int64_t whole(const std::string& type, const char* expected) {
    if (!binary_) return in_.integer(expected);
    switch (size_of(type)) {
      case 1:
        return in_.raw<std::int8_t>(expected);
      case 2:
        return in_.raw<std::int16_t>(expected);
      case 4:
        return in_.raw<std::int32_t>(expected);
      default:
        return in_.raw<std::int64_t>(expected);
    }
  }
  std::size_t count(const char* what, std::size_t bytes_text, std::size_t bytes_binary) {
    return in_.count(what, binary_ ? bytes_binary : bytes_text);
  }

  void read_points() {
    if (seen_points_) in_.fail("there is a second POINTS section, expected one");
    seen_points_ = true;
    const std::size_t n = count("points", 6, 3);
    const std::string type = data_type();
    next_line();
    if (binary_) in_.check_count(n, 3 * size_of(type), "points");
    mesh_.nodes.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = real(type), y = real(type), z = real(type);
      mesh_.nodes.emplace_back(x, y, z);
    }
  }

  void read_cells() {
    if (seen_cells_) in_.fail("there is a second CELLS section, expected one");
    seen_cells_ = true;
    const std::size_t n = count("cells", 2, 1);
    const std::size_t size = count("cell entries", 2, 1);
    std::string_view rest;
    if (!in_.line(rest) || !trimmed(rest).empty())
      in_.fail("expected the end of the line after CELLS n size");
    const std::size_t at = in_.position();
    // A binary block may begin with any bytes, but a count that spells OFFS would be a cell of 1.3e9 nodes.
    if (lower_case(in_.content().substr(at, 7)) == "offsets") return read_offset_cells(n, size);
    if (binary_) in_.check_count(size, 4, "cell entries");
    offsets_ = {0};
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t nodes = whole("int", "a number of nodes");
      if (nodes < 0 || static_cast<std::size_t>(nodes) > size)
        in_.fail(fmt::format("a cell of {} nodes does not fit", nodes));
      for (std::int64_t k = 0; k < nodes; ++k) connectivity_.push_back(whole("int", "a point number"));
      offsets_.push_back(connectivity_.size());
    }
    if (connectivity_.size() + n != size)
      throw InputError({.file = in_.name()},
                       fmt::format("CELLS announces {} entries, {} found", size, connectivity_.size() + n));
  }

  void read_offset_cells(std::size_t n_offsets, std::size_t n_connectivity) {
    in_.token("OFFSETS");
    std::string type = data_type();
    next_line();
    for (std::size_t i = 0; i < n_offsets; ++i) {
      const std::int64_t offset = whole(type, "an offset");
      if (offset < 0 || static_cast<std::size_t>(offset) > n_connectivity ||
          (offsets_.empty() ? offset != 0 : static_cast<std::size_t>(offset) < offsets_.back()))
        in_.fail(fmt::format("cell offset {} is out of order", offset));
      offsets_.push_back(static_cast<std::size_t>(offset));
    }
    if (offsets_.empty()) offsets_ = {0};
    if (lower_case(in_.token("CONNECTIVITY")) != "connectivity") in_.fail("expected CONNECTIVITY");
    type = data_type();
    next_line();
    for (std::size_t i = 0; i < n_connectivity; ++i) connectivity_.push_back(whole(type, "a point number"));
  }

  void read_types() {
    if (seen_types_) in_.fail("there is a second CELL_TYPES section, expected one");
    seen_types_ = true;
    const std::size_t n = count("cell types", 2, 4);
    next_line();
    for (std::size_t i = 0; i < n; ++i) types_.push_back(whole("int", "a cell type"));
  }

  void skip_field() {
    in_.token("a field name");
    const std::size_t arrays = in_.count("arrays", 1);
    for (std::size_t a = 0; a < arrays; ++a) {
      in_.token("an array name");
      if (in_.peek() == "METADATA") in_.token("METADATA"), skip_metadata();
      const std::size_t width = in_.count("components", 1), n = in_.count("tuples", 1);
      const std::string type = lower_case(in_.token("a data type"));
      if (size_of(type) == 0) in_.fail(fmt::format("field data of type '{:.40}' are not read", type));
      next_line();
      if (width != 0 && n > in_.remaining() / width)
        in_.fail("field data announced, but the file is cut short");
      if (binary_)
        in_.bytes(width * n * size_of(type), "field data");
      else
        for (std::size_t i = 0; i < width * n; ++i) in_.token("field data");
      if (in_.peek() == "METADATA") in_.token("METADATA"), skip_metadata();
    }
  }

  void skip_metadata() {  // ends with an empty line
    std::string_view line;
    in_.line(line);
    while (in_.line(line) && !trimmed(line).empty()) {
    }
  }

  Scanner in_;
  TetMesh mesh_;
  bool binary_ = false, seen_points_ = false, seen_cells_ = false, seen_types_ = false;
  std::vector<std::size_t> offsets_;
  std::vector<std::int64_t> connectivity_, types_;
};

}  // namespace

TetMesh read_vtk_legacy(Scanner in) {
  return LegacyReader(std::move(in)).read();
}

}  // namespace forefeel
