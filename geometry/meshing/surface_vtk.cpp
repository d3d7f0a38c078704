// VTK's surfaces: legacy .vtk with DATASET POLYDATA, and .vtp. Polygons and triangle strips; points and lines are
// passed over.

#include <fmt/format.h>

#include <span>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/mesh/vtk_legacy.hpp"
#include "geometry/mesh/vtk_xml.hpp"
#include "geometry/meshing/surface_formats.hpp"

namespace forefeel {
namespace {

struct Faces {
  std::span<const std::int64_t> corners;
  bool strip = false;  // triangle strip, of alternating orientation
};

// Adds the corners first .. first + known - 1 of the file as nodes of the surface.
void add(SurfaceBuilder& out, const Faces& faces, std::int64_t first, std::int64_t known,
         const std::string& where) {
  const auto corner = [&](std::size_t i) {
    const std::int64_t point = faces.corners[i];
    if (point < 0 || point >= known)
      throw InputError({.file = where},
                       fmt::format("a face names point {}, expected 0 to {}", point, known - 1));
    out.polygon.push_back(first + point);
  };
  const std::size_t n = faces.corners.size();
  if (n > static_cast<std::size_t>(most_corners) && !faces.strip)
    throw InputError({.file = where},
                     fmt::format("a face with {} corners, expected at most {}", n, most_corners));
  if (!faces.strip) {
    for (std::size_t i = 0; i < n; ++i) corner(i);
    out.end_polygon();
    return;
  }
  for (std::size_t i = 0; i + 2 < n; ++i) {
    const bool turned = i % 2 == 1;
    corner(turned ? i + 1 : i), corner(turned ? i : i + 1), corner(i + 2);
    out.end_polygon();
  }
}

}  // namespace

void read_polydata(Scanner in, SurfaceBuilder& out) {
  const std::string where = in.name();
  VtkLegacyFile file = read_vtk_file(std::move(in));
  if (!file.polydata)
    throw InputError({.file = where}, "DATASET UNSTRUCTURED_GRID is a mesh, expected POLYDATA");
  out.surface.nodes = std::move(file.points);
  const auto known = static_cast<std::int64_t>(out.surface.nodes.size());
  for (const char* kind : {"polygons", "triangle_strips"}) {
    const auto cells = file.cells.find(kind);
    if (cells == file.cells.end()) continue;
    const VtkCells& of = cells->second;
    for (std::size_t i = 0; i < of.size(); ++i)
      add(out,
          {std::span(of.connectivity).subspan(of.offsets[i], of.offsets[i + 1] - of.offsets[i]),
           cells->first == "triangle_strips"},
          0, known, where);
  }
}

void read_vtp(Scanner in, SurfaceBuilder& out) {
  VtkXmlReader reader(std::move(in), "PolyData");
  reader.read([&](const VtkXmlPiece& piece) {
    const auto first = static_cast<std::int64_t>(out.surface.nodes.size());
    const std::size_t n_points = reader.count(piece, "NumberOfPoints");
    if (n_points == 0) return;
    const std::vector<double> points = reader.reals(reader.array(piece, "Points", ""));
    if (points.size() != 3 * n_points)
      throw InputError({.file = reader.name()},
                       fmt::format("{} coordinates, expected {}", points.size(), 3 * n_points));
    for (std::size_t i = 0; i < n_points; ++i)
      out.surface.nodes.emplace_back(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    for (const auto& [section, number] :
         {std::pair{"Polys", "NumberOfPolys"}, {"Strips", "NumberOfStrips"}}) {
      if (!piece.attributes.contains(number)) continue;
      const std::size_t n = reader.count(piece, number);
      if (n == 0) continue;
      const std::vector<std::int64_t> corners = reader.integers(reader.array(piece, section, "connectivity")),
                                      offsets = reader.integers(reader.array(piece, section, "offsets"));
      if (offsets.size() != n)
        throw InputError({.file = reader.name()},
                         fmt::format("{} offsets of {}, expected {}", offsets.size(), section, n));
      std::int64_t begin = 0;
      for (const std::int64_t end : offsets) {
        if (end < begin || end > static_cast<std::int64_t>(corners.size()))
          throw InputError({.file = reader.name()}, fmt::format("offset {} is out of order", end));
        add(out,
            {std::span(corners).subspan(static_cast<std::size_t>(begin),
                                        static_cast<std::size_t>(end - begin)),
             std::string_view(section) == "Strips"},
            first, static_cast<std::int64_t>(n_points), reader.name());
        begin = end;
      }
    }
  });
}

}  // namespace forefeel
