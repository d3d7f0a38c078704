#include "geometry/mesh/vtk_legacy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <string_view>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

class LegacyReader {
 public:
  explicit LegacyReader(Scanner in) : in_(std::move(in)) {}

  VtkLegacyFile read() {
    read_header();
    while (!in_.at_end()) {
      const std::string keyword = lower_case(in_.token("a keyword"));
      if (keyword == "points")
        read_points();
      else if (is_cells(keyword))
        read_cells(keyword);
      else if (keyword == "cell_types" && !file_.polydata)
        read_types();
      else if (keyword == "field")
        skip_field();
      else if (keyword == "metadata")
        skip_metadata();
      else if (keyword == "point_data" || keyword == "cell_data") {
        read_attributes(keyword);
        break;
      } else
        in_.fail(fmt::format("keyword '{:.40}' is unknown, expected {}", keyword,
                             file_.polydata ? "POINTS or POLYGONS" : "POINTS, CELLS or CELL_TYPES"));
    }
    const bool cells = file_.polydata || file_.cells.contains("cells");
    if (!seen_points_ || !cells || (!file_.polydata && !seen_types_))
      throw InputError({.file = in_.name()},
                       fmt::format("ends without {}, the file is cut short", !seen_points_ ? "POINTS"
                                                                             : !cells      ? "CELLS"
                                                                                           : "CELL_TYPES"));
    return std::move(file_);
  }

 private:
  bool is_cells(const std::string& keyword) const {
    if (!file_.polydata) return keyword == "cells";
    return keyword == "polygons" || keyword == "triangle_strips" || keyword == "lines" ||
           keyword == "vertices";
  }

  void read_header() {
    std::string_view line;
    const bool any = in_.line(line);
    if (any && line.starts_with("<"))
      in_.fail("is XML, expected '# vtk DataFile Version' of a legacy file; an XML file ends in .vtu");
    if (!any || !lower_case(line).starts_with("# vtk datafile version"))
      in_.fail("is not a legacy VTK file, expected '# vtk DataFile Version'");
    if (!in_.line(line)) in_.fail("the file ends where a title was expected");
    const std::string mode = lower_case(in_.token("ASCII or BINARY"));
    if (mode != "ascii" && mode != "binary")
      in_.fail(fmt::format("'{:.40}' stands where ASCII or BINARY was expected", mode));
    binary_ = mode == "binary";
    in_.swap_bytes(binary_ && std::endian::native == std::endian::little);
    if (lower_case(in_.token("DATASET")) != "dataset") in_.fail("expected DATASET");
    const std::string kind = lower_case(in_.token("UNSTRUCTURED_GRID"));
    file_.polydata = kind == "polydata";
    if (!file_.polydata && kind != "unstructured_grid")
      in_.fail(fmt::format(
          "DATASET {:.40} is not read, expected UNSTRUCTURED_GRID (or POLYDATA, for a surface)", kind));
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
    file_.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = real(type), y = real(type), z = real(type);
      file_.points.emplace_back(x, y, z);
    }
  }

  void read_cells(const std::string& keyword) {
    if (file_.cells.contains(keyword))
      in_.fail(fmt::format("there is a second {} section, expected one", upper(keyword)));
    VtkCells& to = file_.cells[keyword];
    const std::size_t n = count("cells", 2, 1);
    const std::size_t size = count("cell entries", 2, 1);
    std::string_view rest;
    if (!in_.line(rest) || !trimmed(rest).empty())
      in_.fail(fmt::format("expected the end of the line after {} n size", upper(keyword)));
    const std::size_t at = in_.position();
    // A binary block may begin with any bytes. But the bytes "OFFS", read as a count, would mean a cell of 1.3e9 nodes.
    if (lower_case(in_.content().substr(at, 7)) == "offsets") return read_offset_cells(n, size, to);
    if (binary_) in_.check_count(size, 4, "cell entries");
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t nodes = whole("int", "a number of nodes");
      if (nodes < 0 || static_cast<std::size_t>(nodes) > size)
        in_.fail(fmt::format("a cell of {} nodes does not fit", nodes));
      for (std::int64_t k = 0; k < nodes; ++k) to.connectivity.push_back(whole("int", "a point number"));
      to.offsets.push_back(to.connectivity.size());
    }
    if (to.connectivity.size() + n != size)
      throw InputError({.file = in_.name()}, fmt::format("{} announces {} entries, {} found", upper(keyword),
                                                         size, to.connectivity.size() + n));
  }

  void read_offset_cells(std::size_t n_offsets, std::size_t n_connectivity, VtkCells& to) {
    to.offsets.clear();
    in_.token("OFFSETS");
    std::string type = data_type();
    next_line();
    for (std::size_t i = 0; i < n_offsets; ++i) {
      const std::int64_t offset = whole(type, "an offset");
      if (offset < 0 || static_cast<std::size_t>(offset) > n_connectivity ||
          (to.offsets.empty() ? offset != 0 : static_cast<std::size_t>(offset) < to.offsets.back()))
        in_.fail(fmt::format("cell offset {} is out of order", offset));
      to.offsets.push_back(static_cast<std::size_t>(offset));
    }
    if (to.offsets.empty()) to.offsets = {0};
    if (lower_case(in_.token("CONNECTIVITY")) != "connectivity") in_.fail("expected CONNECTIVITY");
    type = data_type();
    next_line();
    for (std::size_t i = 0; i < n_connectivity; ++i) to.connectivity.push_back(whole(type, "a point number"));
  }

  void read_types() {
    if (seen_types_) in_.fail("there is a second CELL_TYPES section, expected one");
    seen_types_ = true;
    const std::size_t n = count("cell types", 2, 4);
    next_line();
    for (std::size_t i = 0; i < n; ++i) file_.types.push_back(whole("int", "a cell type"));
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

  // A count that read_attribute() compares with the file.
  std::size_t any_count(const char* expected) {
    return static_cast<std::size_t>(in_.integer(expected, 0, std::int64_t{1} << 40));
  }

  // POINT_DATA n and CELL_DATA n up to the end of the file, or to an attribute of an unknown kind.
  void read_attributes(std::string section) {
    std::size_t n = any_count("a number of values");
    while (!in_.at_end()) {
      const std::string keyword = lower_case(in_.token("an attribute"));
      if (keyword == "point_data" || keyword == "cell_data") {
        section = keyword;
        n = any_count("a number of values");
      } else if (keyword == "scalars") {
        const std::string name(in_.token("an array name")), type = lower_case(in_.token("a data type"));
        std::string_view rest;
        std::int64_t width = 1;
        in_.line(rest);
        if (!trimmed(rest).empty() && (!parse_integer(trimmed(rest), width) || width < 0)) return;
        if (lower_case(in_.peek()) != "lookup_table") return;
        in_.token("LOOKUP_TABLE"), in_.token("a table");
        if (!read_attribute(section, name, type, static_cast<std::size_t>(width), n)) return;
      } else if (keyword == "vectors" || keyword == "normals" || keyword == "tensors" ||
                 keyword == "global_ids" || keyword == "pedigree_ids") {
        const std::string name(in_.token("an array name")), type = lower_case(in_.token("a data type"));
        const std::size_t width = keyword == "tensors" ? 9 : keyword.ends_with("ids") ? 1 : 3;
        const std::string& kept = keyword.ends_with("ids") ? std::string("ids") : section;
        if (!read_attribute(kept, name, type, width, n)) return;
      } else if (keyword == "field") {
        in_.token("a field name");
        const std::size_t arrays = in_.count("arrays", 1);
        for (std::size_t a = 0; a < arrays; ++a) {
          const std::string name(in_.token("an array name"));
          const std::size_t width = any_count("components"), tuples = any_count("tuples");
          const std::string type = lower_case(in_.token("a data type"));
          if (!read_attribute(section, name, type, width, tuples)) return;
          if (in_.peek() == "METADATA") in_.token("METADATA"), skip_metadata();
        }
      } else if (keyword == "texture_coordinates") {
        in_.token("an array name");
        const std::size_t width = any_count("components");
        if (!read_attribute("", "", lower_case(in_.token("a data type")), width, n)) return;
      } else if (keyword == "color_scalars" || keyword == "lookup_table") {
        in_.token("an array name");
        const std::size_t size = any_count("a size");
        const bool table = keyword == "lookup_table";
        if (!read_attribute("", "", "unsigned_char", table ? 4 : size, table ? size : n)) return;
      } else if (keyword == "metadata") {
        skip_metadata();
      } else {
        return;
      }
    }
  }

  // Keeps arrays of one component of CELL_DATA. False if the values cannot be passed over.
  bool read_attribute(const std::string& section, const std::string& name, const std::string& type,
                      std::size_t width, std::size_t tuples) {
    if (size_of(type) == 0) return false;
    next_line();
    if (width != 0 && tuples > in_.remaining() / width)
      in_.fail("values announced, but the file is cut short");
    const bool kept = section == "cell_data" && width == 1;
    std::vector<double>* values = kept ? &file_.cell_arrays[name] : nullptr;
    for (std::size_t i = 0; i < width * tuples; ++i) {
      const double value = attribute(type);
      if (values) values->push_back(value);
    }
    return true;
  }

  double attribute(const std::string& type) {
    if (!binary_) return in_.real("a value");
    if (type == "float") return in_.raw<float>("a value");
    if (type == "double") return in_.raw<double>("a value");
    return static_cast<double>(whole(type, "a value"));
  }

  void skip_metadata() {  // ends with an empty line
    std::string_view line;
    in_.line(line);
    while (in_.line(line) && !trimmed(line).empty()) {
    }
  }

  Scanner in_;
  VtkLegacyFile file_;
  bool binary_ = false, seen_points_ = false, seen_types_ = false;
};

}  // namespace

VtkLegacyFile read_vtk_file(Scanner in) {
  return LegacyReader(std::move(in)).read();
}

}  // namespace forefeel
