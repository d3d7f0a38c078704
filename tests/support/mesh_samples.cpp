#include "tests/support/mesh_samples.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <vector>

namespace forefeel::test {
namespace {

template <class T>
void put(std::string& out, T value, bool big_endian = false) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (big_endian == (std::endian::native == std::endian::little))
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  out.append(bytes, sizeof(T));
}

std::string base64(std::string_view data) {
  const std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < data.size() ? static_cast<unsigned char>(data[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= data.size() ? letters[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string gmsh22(const TetMesh& m, bool binary, bool big = false) {
  std::string s = fmt::format("$MeshFormat\n2.2 {} 8\n", binary ? 1 : 0);
  if (binary) put(s, std::int32_t{1}, big), s += "\n";
  s += "$EndMeshFormat\n$PhysicalNames\n2\n0 7 \"held\"\n3 1 \"the body\"\n$EndPhysicalNames\n";
  s += fmt::format("$Nodes\n{}\n", m.nodes.size());
  for (std::size_t i = 0; i < m.nodes.size(); ++i) {
    const auto tag = static_cast<std::int32_t>(10 * i + 3);  // tags need not be dense
    if (!binary) {
      s += fmt::format("{} {} {} {}\n", tag, m.nodes[i].x(), m.nodes[i].y(), m.nodes[i].z());
    } else {
      put(s, tag, big);
      for (int k = 0; k < 3; ++k) put(s, m.nodes[i][k], big);
    }
  }
  s += fmt::format("{}$EndNodes\n$Elements\n{}\n", binary ? "\n" : "", m.tets.size() + 2);
  const std::vector<std::int32_t> held{3, 23};
  if (binary) {
    for (const std::int32_t v : {15, 2, 2}) put(s, v, big);
    for (std::int32_t i = 0; i < 2; ++i)
      for (const std::int32_t v : {i + 1, 7, 7, held[static_cast<std::size_t>(i)]}) put(s, v, big);
    for (const std::int32_t v : {4, static_cast<std::int32_t>(m.tets.size()), 2}) put(s, v, big);
    for (std::size_t t = 0; t < m.tets.size(); ++t) {
      for (const std::int32_t v : {static_cast<std::int32_t>(t) + 3, 1, 1}) put(s, v, big);
      for (const NodeIndex n : m.tets[t]) put(s, static_cast<std::int32_t>(10 * n + 3), big);
    }
    s += "\n";
  } else {
    for (std::size_t i = 0; i < 2; ++i) s += fmt::format("{} 15 2 7 7 {}\n", i + 1, held[i]);
    for (std::size_t t = 0; t < m.tets.size(); ++t) {
      s += fmt::format("{} 4 2 1 1", t + 3);
      for (const NodeIndex n : m.tets[t]) s += fmt::format(" {}", 10 * n + 3);
      s += "\n";
    }
  }
  return s + "$EndElements\n";
}

std::string gmsh41_text(const TetMesh& m) {
  std::string s =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n0 7 \"held\"\n$EndPhysicalNames\n";
  s += "$Entities\n1 0 0 1\n4 0 0 0 1 7\n9 0 0 0 1 1 1 0 0\n$EndEntities\n";
  s += fmt::format("$Nodes\n2 {} 1 {}\n", m.nodes.size(), m.nodes.size());
  // Two blocks, the second with parametric coordinates.
  const std::size_t half = m.nodes.size() / 2;
  for (const auto& [from, to, parametric] :
       {std::tuple{std::size_t{0}, half, 0}, std::tuple{half, m.nodes.size(), 1}}) {
    s += fmt::format("3 9 {} {}\n", parametric, to - from);
    for (std::size_t i = from; i < to; ++i) s += fmt::format("{}\n", i + 1);
    for (std::size_t i = from; i < to; ++i)
      s += fmt::format("{} {} {}{}\n", m.nodes[i].x(), m.nodes[i].y(), m.nodes[i].z(),
                       parametric ? " 0.1 0.2 0.3" : "");
  }
  s += fmt::format("$EndNodes\n$Elements\n2 {} 1 {}\n0 4 15 2\n1 1\n2 3\n3 9 4 {}\n", m.tets.size() + 2,
                   m.tets.size() + 2, m.tets.size());
  for (std::size_t t = 0; t < m.tets.size(); ++t)
    s += fmt::format("{} {} {} {} {}\n", t + 3, m.tets[t][0] + 1, m.tets[t][1] + 1, m.tets[t][2] + 1,
                     m.tets[t][3] + 1);
  return s + "$EndElements\n";
}

std::string gmsh41_binary(const TetMesh& m) {
  const auto ints = [](std::string& s, std::initializer_list<std::int32_t> v) {
    for (const auto i : v) put(s, i);
  };
  const auto sizes = [](std::string& s, std::initializer_list<std::uint64_t> v) {
    for (const auto i : v) put(s, i);
  };
  const auto reals = [](std::string& s, std::initializer_list<double> v) {
    for (const auto i : v) put(s, i);
  };
  std::string s = "$MeshFormat\n4.1 1 8\n";
  ints(s, {1});
  s += "\n$EndMeshFormat\n$PhysicalNames\n1\n0 7 \"held\"\n$EndPhysicalNames\n$Entities\n";
  sizes(s, {1, 0, 0, 1}), ints(s, {4}), reals(s, {0, 0, 0}), sizes(s, {1}), ints(s, {7});
  ints(s, {9}), reals(s, {0, 0, 0, 1, 1, 1}), sizes(s, {0, 0});
  s += "\n$EndEntities\n$Nodes\n";
  const auto n = static_cast<std::uint64_t>(m.nodes.size()), t = static_cast<std::uint64_t>(m.tets.size());
  sizes(s, {1, n, 1, n}), ints(s, {3, 9, 0}), sizes(s, {n});
  for (std::uint64_t i = 0; i < n; ++i) sizes(s, {i + 1});
  for (const Vec3& node : m.nodes) reals(s, {node.x(), node.y(), node.z()});
  s += "\n$EndNodes\n$Elements\n";
  sizes(s, {2, t + 2, 1, t + 2}), ints(s, {0, 4, 15}), sizes(s, {2, 1, 1, 2, 3}), ints(s, {3, 9, 4}),
      sizes(s, {t});
  for (std::uint64_t e = 0; e < t; ++e) {
    sizes(s, {e + 3});
    for (const NodeIndex node : m.tets[e]) sizes(s, {static_cast<std::uint64_t>(node) + 1});
  }
  return s + "\n$EndElements\n";
}

std::string vtk(const TetMesh& m, bool binary, bool offsets) {
  std::string s = fmt::format("# vtk DataFile Version {}\na mesh\n{}\nDATASET UNSTRUCTURED_GRID\n",
                              offsets ? "5.1" : "3.0", binary ? "BINARY" : "ASCII");
  const auto reals = [&](double v) { binary ? put(s, v, true) : void(s += fmt::format("{} ", v)); };
  const auto whole = [&](auto v) { binary ? put(s, v, true) : void(s += fmt::format("{} ", v)); };
  s += fmt::format("POINTS {} double\n", m.nodes.size());
  for (const Vec3& node : m.nodes) reals(node.x()), reals(node.y()), reals(node.z());
  const std::size_t cells = m.tets.size();
  if (offsets) {
    s += fmt::format("\nCELLS {} {}\nOFFSETS vtktypeint64\n", cells + 1, 4 * cells);
    for (std::size_t i = 0; i <= cells; ++i) whole(static_cast<std::int64_t>(4 * i));
    s += "\nCONNECTIVITY vtktypeint64\n";
    for (const Tet& tet : m.tets)
      for (const NodeIndex node : tet) whole(static_cast<std::int64_t>(node));
  } else {
    s += fmt::format("\nCELLS {} {}\n", cells, 5 * cells);
    for (const Tet& tet : m.tets) {
      whole(std::int32_t{4});
      for (const NodeIndex node : tet) whole(static_cast<std::int32_t>(node));
    }
  }
  s += fmt::format("\nCELL_TYPES {}\n", cells);
  for (std::size_t i = 0; i < cells; ++i) whole(std::int32_t{10});
  return s + "\n";
}

enum class VtuKind { ascii, inline_base64, appended_raw, appended_base64 };

std::string vtu(const TetMesh& m, VtuKind kind) {
  std::string points, connectivity, offsets, types, appended, text[4];
  for (const Vec3& node : m.nodes)
    for (int k = 0; k < 3; ++k) put(points, node[k]), text[0] += fmt::format("{} ", node[k]);
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    for (const NodeIndex node : m.tets[t])
      put(connectivity, std::int64_t{node}), text[1] += fmt::format("{} ", node);
    put(offsets, static_cast<std::int64_t>(4 * t + 4)), text[2] += fmt::format("{} ", 4 * t + 4);
    put(types, std::uint8_t{10}), text[3] += "10 ";
  }
  int number = 0;
  const auto array = [&](const char* type, const char* name, const std::string& data) {
    std::string sized;
    put(sized, static_cast<std::uint64_t>(data.size()));
    sized += data;
    const std::string& ascii = text[number++];
    const std::string head =
        fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=", type, name,
                    name[0] == 'P' ? 3 : 1);
    if (kind == VtuKind::ascii) return head + "\"ascii\">\n" + ascii + "\n</DataArray>\n";
    if (kind == VtuKind::inline_base64) return head + "\"binary\">\n" + base64(sized) + "\n</DataArray>\n";
    const std::string item = head + fmt::format("\"appended\" offset=\"{}\"/>\n", appended.size());
    appended += kind == VtuKind::appended_raw ? sized : base64(sized);
    return item;
  };
  std::string s =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
  s += fmt::format(
      "<UnstructuredGrid>\n<!-- a <comment> -->\n<Piece NumberOfPoints=\"{}\" "
      "NumberOfCells=\"{}\">\n<Points>\n",
      m.nodes.size(), m.tets.size());
  s += array("Float64", "Points", points);
  s += "</Points>\n<Cells>\n";
  s += array("Int64", "connectivity", connectivity);
  s += array("Int64", "offsets", offsets);
  s += array("UInt8", "types", types);
  s += "</Cells>\n</Piece>\n</UnstructuredGrid>\n";
  if (!appended.empty())
    s += fmt::format("<AppendedData encoding=\"{}\">\n_{}\n</AppendedData>\n",
                     kind == VtuKind::appended_raw ? "raw" : "base64", appended);
  return s + "</VTKFile>\n";
}

std::string medit(const TetMesh& m) {
  std::string s =
      fmt::format("MeshVersionFormatted 2\n# a comment\nDimension\n3\nVertices\n{}\n", m.nodes.size());
  for (std::size_t i = 0; i < m.nodes.size(); ++i)
    s += fmt::format("{} {} {} {}\n", m.nodes[i].x(), m.nodes[i].y(), m.nodes[i].z(),
                     i == 0 || i == 2 ? 7 : 0);
  s += fmt::format("Triangles\n1\n1 2 3 0\nTetrahedra\n{}\n", m.tets.size());
  for (const Tet& t : m.tets) s += fmt::format("{} {} {} {} 0\n", t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  return s + "End\n";
}

}  // namespace

TetMesh sample_mesh() {
  TetMesh m;
  m.nodes = {{0, 0, 0}, {1.25, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0.1}, {1e-3, -1.5, 0.25}};
  m.tets = {{0, 1, 2, 3}, {1, 4, 2, 3}, {0, 5, 1, 3}};
  m.groups["held"] = {0, 2};
  return m;
}

std::map<std::string, std::string> sample_mesh_files() {
  const TetMesh m = sample_mesh();
  return {{"gmsh22_ascii.msh", gmsh22(m, false)},           {"gmsh22_binary.msh", gmsh22(m, true)},
          {"gmsh22_big_endian.msh", gmsh22(m, true, true)}, {"gmsh41_ascii.msh", gmsh41_text(m)},
          {"gmsh41_binary.msh", gmsh41_binary(m)},          {"legacy3_ascii.vtk", vtk(m, false, false)},
          {"legacy3_binary.vtk", vtk(m, true, false)},      {"legacy5_ascii.vtk", vtk(m, false, true)},
          {"legacy5_binary.vtk", vtk(m, true, true)},       {"ascii.vtu", vtu(m, VtuKind::ascii)},
          {"inline.vtu", vtu(m, VtuKind::inline_base64)},   {"raw.vtu", vtu(m, VtuKind::appended_raw)},
          {"base64.vtu", vtu(m, VtuKind::appended_base64)}, {"medit.mesh", medit(m)}};
}

Surface unit_cube() {
  Surface s;
  for (int i = 0; i < 8; ++i) s.nodes.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return s;
}

// Legacy .vtk with DATASET POLYDATA; offsets: as written from version 5.1 on.
static std::string polydata(const Surface& surface, bool binary, bool offsets) {
  std::string s =
      fmt::format("# vtk DataFile Version {}\na surface\n{}\nDATASET POLYDATA\nPOINTS {} double\n",
                  offsets ? "5.1" : "3.0", binary ? "BINARY" : "ASCII", surface.nodes.size());
  for (const Vec3& n : surface.nodes) {
    if (!binary) s += fmt::format("{} {} {}\n", n.x(), n.y(), n.z());
    for (int k = 0; binary && k < 3; ++k) put(s, n[k], true);
  }
  const std::size_t faces = surface.triangles.size();
  if (offsets) {
    s += fmt::format("METADATA\nINFORMATION 0\n\nPOLYGONS {} {}\nOFFSETS vtktypeint64\n", faces + 1,
                     3 * faces);
    for (std::size_t i = 0; i <= faces; ++i) s += fmt::format("{} ", 3 * i);
    s += "\nCONNECTIVITY vtktypeint64\n";
    for (const auto& [a, b, c] : surface.triangles) s += fmt::format("{} {} {}\n", a, b, c);
    return s;
  }
  s += fmt::format("\nPOLYGONS {} {}\n", faces, 4 * faces);
  for (const auto& [a, b, c] : surface.triangles) {
    if (!binary) s += fmt::format("3 {} {} {}\n", a, b, c);
    for (const NodeIndex v : {NodeIndex{3}, a, b, c})
      if (binary) put(s, static_cast<std::int32_t>(v), true);
  }
  return s + fmt::format("\nCELL_DATA {}\nVECTORS normal float\n", faces) +
         (binary ? std::string(12 * faces, '\0') : [&] {
           std::string zeros;
           for (std::size_t i = 0; i < faces; ++i) zeros += "0 0 0\n";
           return zeros;
         }());
}

std::map<std::string, std::string> surface_files(const Surface& surface) {
  std::string obj = "# a surface\no body\n",
              off = fmt::format("OFF\n{} {} 0\n", surface.nodes.size(), surface.triangles.size()),
              stl = "solid body\n";
  std::string ply_body, ply_binary, ply_big, stl_binary(80, ' ');
  for (const Vec3& n : surface.nodes) {
    obj += fmt::format("v {} {} {}\n", n.x(), n.y(), n.z()),
        off += fmt::format("{} {} {}\n", n.x(), n.y(), n.z());
    ply_body += fmt::format("{} {} {} 255\n", n.x(), n.y(), n.z());
    for (int k = 0; k < 3; ++k) put(ply_binary, n[k]), put(ply_big, n[k], true);
    put(ply_binary, std::uint8_t{255}), put(ply_big, std::uint8_t{255}, true);
  }
  put(stl_binary, static_cast<std::uint32_t>(surface.triangles.size()));
  for (const auto& [a, b, c] : surface.triangles) {
    obj += fmt::format("f {}/1/1 {}//1 {}\n", a + 1, b + 1,
                       static_cast<int>(c) - static_cast<int>(surface.nodes.size()));
    off += fmt::format("3 {} {} {} 0.1 0.2 0.3\n", a, b, c), ply_body += fmt::format("3 {} {} {}\n", a, b, c);
    put(ply_binary, std::uint8_t{3}), put(ply_big, std::uint8_t{3}, true);
    for (const NodeIndex n : {a, b, c})
      put(ply_binary, static_cast<std::int32_t>(n)), put(ply_big, static_cast<std::int32_t>(n), true);
    stl += "facet normal 0 0 0\n outer loop\n";
    for (int k = 0; k < 3; ++k) put(stl_binary, 0.f);
    for (const NodeIndex n : {a, b, c}) {
      const Vec3& node = surface.nodes[static_cast<std::size_t>(n)];
      stl += fmt::format("  vertex {} {} {}\n", node.x(), node.y(), node.z());
      for (int k = 0; k < 3; ++k) put(stl_binary, static_cast<float>(node[k]));
    }
    put(stl_binary, std::uint16_t{0});
    stl += " endloop\nendfacet\n";
  }
  const auto header = [&](const char* format) {
    return fmt::format(
        "ply\nformat {} 1.0\ncomment none\nelement vertex {}\nproperty double x\nproperty double y\nproperty "
        "double z\nproperty uchar red\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        format, surface.nodes.size(), surface.triangles.size());
  };
  std::string two_words = stl;
  for (const char* word : {"loop", "facet"})
    for (std::size_t at = 0; (at = two_words.find(std::string("end") + word, at)) != std::string::npos;)
      two_words.insert(at + 3, " ");
  return {{"s.obj", obj},
          {"s.off", off},
          {"text.stl", stl + "endsolid body\n"},
          {"spaced.stl", two_words + "end solid body\n"},
          {"old.vtk", polydata(surface, false, false)},
          {"old_binary.vtk", polydata(surface, true, false)},
          {"new.vtk", polydata(surface, false, true)},
          {"binary.stl", stl_binary},
          {"text.ply", header("ascii") + ply_body},
          {"little.ply", header("binary_little_endian") + ply_binary},
          {"big.ply", header("binary_big_endian") + ply_big}};
}

}  // namespace forefeel::test
