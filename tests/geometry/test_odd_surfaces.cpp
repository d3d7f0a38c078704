// Surface files as their formats allow them, and as they are often wrong.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/surface.hpp"
#include "tests/support/test.hpp"

namespace {

// A prism over a polygon: caps of one face each.
struct Prism {
  std::vector<Vec3> nodes;
  std::vector<std::vector<std::size_t>> faces;
};

Prism prism_over(const std::vector<Vec3>& low, double height) {
  Prism prism;
  const std::size_t n = low.size();
  for (const double z : {0.0, height})
    for (const Vec3& x : low) prism.nodes.push_back(x + Vec3(0, 0, z));
  prism.faces.resize(2);
  for (std::size_t i = 0; i < n; ++i) {
    prism.faces[0].push_back(n - 1 - i);
    prism.faces[1].push_back(n + i);
    prism.faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  return prism;
}

// An L of 5 squares of 2 cm, 3 cm high: 60 cm^3.
Prism l_prism() {
  std::vector<Vec3> low;
  for (const auto& [x, y] : {std::pair(0, 0), {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}})
    low.emplace_back(0.02 * x, 0.02 * y, 0);
  return prism_over(low, 0.03);
}

std::string obj_of(const Prism& prism) {
  std::string text;
  for (const Vec3& x : prism.nodes) text += fmt::format("v {} {} {}\n", x[0], x[1], x[2]);
  for (const auto& face : prism.faces) {
    text += "f";
    for (const std::size_t i : face) text += fmt::format(" {}", i + 1);
    text += "\n";
  }
  return text;
}

std::string counted_faces(const Prism& prism) {
  std::string text;
  for (const auto& face : prism.faces) text += fmt::format("{} {}\n", face.size(), fmt::join(face, " "));
  return text;
}

std::string nodes_of(const Prism& prism) {
  std::string text;
  for (const Vec3& x : prism.nodes) text += fmt::format("{} {} {}\n", x[0], x[1], x[2]);
  return text;
}

std::map<std::string, std::string> files_of(const Prism& prism) {
  const std::size_t n = prism.nodes.size(), faces = prism.faces.size();
  std::size_t entries = 0;
  for (const auto& face : prism.faces) entries += face.size() + 1;
  return {
      {"p.obj", obj_of(prism)},
      {"p.off", fmt::format("OFF\n{} {} 0\n{}{}", n, faces, nodes_of(prism), counted_faces(prism))},
      {"p.ply", fmt::format("ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
                            "property double z\nelement face {}\nproperty list uchar int vertex_indices\n"
                            "end_header\n{}{}",
                            n, faces, nodes_of(prism), counted_faces(prism))},
      {"p.vtk", fmt::format("# vtk DataFile Version 3.0\nprism\nASCII\nDATASET POLYDATA\nPOINTS {} double\n"
                            "{}POLYGONS {} {}\n{}",
                            n, nodes_of(prism), faces, entries, counted_faces(prism))}};
}

void check_volume(const Prism& prism, double volume) {
  const TemporaryFolder folder;
  for (const auto& [name, content] : files_of(prism)) {
    INFO(name);
    const Surface surface = read_surface(folder.write(name, content));
    const SurfaceSummary sum = summarise(surface);
    CHECK(sum.closed());
    CHECK(sum.volume == Approx(volume).epsilon(1e-12));
    CHECK(surface.remarks.empty());
  }
}

}  // namespace

TEST_CASE("concave polygons are triangulated in their plane, in every format, wherever they lie") {
  check_volume(l_prism(), 60e-6);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int variant = 0; variant < 10; ++variant) {
    INFO(variant);
    Prism prism = l_prism();
    const double scale = std::pow(10, number(random));
    const Eigen::Quaterniond turn(number(random), number(random), number(random), number(random));
    const Vec3 shift(number(random), 0.2, 0);
    for (Vec3& x : prism.nodes) x = scale * (turn.normalized() * x) + shift;
    for (auto& face : prism.faces)  // any corner may be the first
      std::rotate(face.begin(), face.begin() + variant % static_cast<int>(face.size()), face.end());
    std::ranges::shuffle(prism.faces, random);
    check_volume(prism, 60e-6 * scale * scale * scale);
  }
}

TEST_CASE("a comb, a star and a polygon that walks a bridge to its hole have their exact areas") {
  std::vector<Vec3> comb{{0, 0, 0}};
  for (int tooth = 0; tooth < 10; ++tooth) {  // 1 wide, 3 high, on a bar of 1
    comb.emplace_back(2 * tooth + 1, 0, 0);
    if (tooth < 9) {
      comb.emplace_back(2 * tooth + 1, -3, 0);
      comb.emplace_back(2 * tooth + 2, -3, 0);
      comb.emplace_back(2 * tooth + 2, 0, 0);
    }
  }
  comb.emplace_back(19, -4, 0);
  comb.emplace_back(0, -4, 0);
  std::ranges::reverse(comb);
  check_volume(prism_over(comb, 2), 2 * (19 + 10 * 3));
  std::vector<Vec3> star;
  for (int k = 0; k < 14; ++k) {
    const double r = k % 2 ? 1 : 3, a = std::numbers::pi * k / 7;
    star.emplace_back(r * std::cos(a), r * std::sin(a), 0);
  }
  check_volume(prism_over(star, 1), 7 * 3 * std::sin(std::numbers::pi / 7));

  const TemporaryFolder folder;
  const Surface ring =
      read_surface(folder.write("ring.obj",
                                "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\n"
                                "v 3 1 0\nf 1 2 3 4 1 5 6 7 8 5\n"));
  CHECK(ring.remarks.empty());
  double area = 0;
  for (const auto& [a, b, c] : ring.triangles) {
    const double part = 0.5 * (ring.nodes[b] - ring.nodes[a]).cross(ring.nodes[c] - ring.nodes[a]).z();
    CHECK(part > 0);  // parts of a fan that overlap have the same sum
    area += part;
  }
  CHECK(area == Approx(16 - 4).epsilon(1e-14));
}

TEST_CASE("a corner that is repeated, and the first one at the end, count once") {
  Prism twice = l_prism(), closed = l_prism();
  for (auto& face : twice.faces) face.insert(face.begin() + 1, face[1]);
  for (auto& face : closed.faces) face.push_back(face.front());
  check_volume(twice, 60e-6);
  check_volume(closed, 60e-6);
}

TEST_CASE("faces that are not planar, or cross themselves, are said with their line") {
  const TemporaryFolder folder;
  const std::string corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 {}\nv 0 2 0\n";
  const Surface flat =
      read_surface(folder.write("flat.obj", fmt::format(fmt::runtime(corners), 0) + "f 1 2 3 4 5\n"));
  CHECK(flat.remarks.empty());
  const Surface bent =
      read_surface(folder.write("bent.obj", fmt::format(fmt::runtime(corners), 0.5) + "f 1 2 3 4 5\n"));
  REQUIRE(bent.remarks.size() == 1);
  CHECK_THAT(bent.remarks[0], Contains("line 6: a face", "is not planar"));
  const Surface crossed =
      read_surface(folder.write("bow.obj", "v 0 0 0\nv 2 2 0\nv 2.5 0 0\nv 0 1 0\nf 1 2 3 4\n"));
  REQUIRE(crossed.remarks.size() == 1);
  CHECK_THAT(crossed.remarks[0], Contains("line 5: a face crosses itself"));
  // A quadrilateral has two triangulations, equally right.
  const Surface quad =
      read_surface(folder.write("quad.obj", "v 0 0 0\nv 1 0 0.2\nv 1 1 0\nv 0 1 0.2\nf 1 2 3 4\n"));
  CHECK(quad.remarks.empty());
}

TEST_CASE("what the formats allow is read: CR alone, lines that go on, missing keywords, padding") {
  const TemporaryFolder folder;
  const auto volume = [&](const char* name, const std::string& content) {
    INFO(name);
    const SurfaceSummary sum = summarise(read_surface(folder.write(name, content)));
    CHECK(sum.volume == Approx(60e-6).epsilon(1e-6));
  };
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return text;
  };
  const auto files = files_of(l_prism());
  for (const auto& [name, content] : files) {
    volume(name.c_str(), replaced(content, "\n", "\r"));
    volume(name.c_str(), replaced(content, "\n", "\r\n"));
    volume(name.c_str(), "\xef\xbb\xbf" + content);
  }
  const std::string& obj = files.at("p.obj");
  volume("a.obj", replaced(obj, "f 6 5 4", "f 6 5 \\\n  4"));
  volume("a.obj", obj.substr(obj.find('f')) + obj.substr(0, obj.find('f')));
  volume("a.obj", replaced(obj, "\n", " # c\n"));
  volume("a.obj", obj.substr(0, obj.size() - 1) + " \\");
  const std::string off = files.at("p.off").substr(4);
  for (const char* start : {"", "off\n", "OFF ", "# c\nOFF # c\n\n"}) volume("a.off", start + off);
  volume("a.off", "STOFF\n" + replaced(off, "0\n", "0 0.5 0.5\n").replace(0, off.find('\n'), "12 8 0"));
  volume("a.off", replaced("OFF\n" + off, "12 8 0", "12 8"));
}

TEST_CASE("PLY: properties before the corners, and lists longer than a byte counts") {
  const TemporaryFolder folder;
  const std::string ascii =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty uchar material\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n7 3 0 2 1\n7 3 0 1 3\n7 3 1 2 3\n7 3 0 3 2\n";
  CHECK(summarise(read_surface(folder.write("a.ply", ascii))).volume == Approx(1.0 / 6));
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty list ushort float descriptor\nelement face 4\n"
      "property list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 3; ++axis) put(i == axis + 1 ? 1.0F : 0.0F);
    put(std::uint16_t{300});
    binary.append(1200, '\3');
  }
  for (const std::array<std::int32_t, 3>& face : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}) {
    put(std::uint8_t{3});
    for (const std::int32_t corner : face) put(corner);
  }
  CHECK(summarise(read_surface(folder.write("b.ply", binary))).volume == Approx(1.0 / 6));
}

TEST_CASE("STL: what follows the last triangle is said or refused, and text is told from binary data") {
  const TemporaryFolder folder;
  const auto stl = [](std::uint32_t announced, std::size_t bytes, const char* head) {
    std::string content(head);
    content.resize(80, ' ');
    content.append(reinterpret_cast<const char*>(&announced), 4);
    const float corners[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (int t = 0; t < 2; ++t) {
      content.append(reinterpret_cast<const char*>(corners), 48);
      content.append(2, '\7');
    }
    return content.append(bytes, '\0');
  };
  CHECK(read_surface(folder.write("a.stl", stl(2, 0, "solid x"))).triangles.size() == 2);
  const Surface padded = read_surface(folder.write("a.stl", stl(2, 2, "solid x")));
  REQUIRE(padded.remarks.size() == 1);
  CHECK_THAT(padded.remarks[0], Contains("2 bytes behind the last triangle"));
  CHECK_THAT(error_of([&] { read_surface(folder.write("a.stl", stl(1, 0, "x"))); }),
             Contains("1 triangles are announced, and 50 bytes follow them"));
  CHECK_THAT(error_of([&] { read_surface(folder.write("a.stl", stl(3, 0, "x"))); }), Contains("cut short"));
}

TEST_CASE("counts of the header that are off by one are refused or said with their line") {
  const TemporaryFolder folder;
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  const auto ply = [&](int vertices, int edges, int face_count) {
    return fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\nelement edge {}\nproperty int vertex1\nproperty int vertex2\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n{}{}{}",
        vertices, edges, face_count, corners, edges > 0 ? "0 1\n" : "", faces);
  };
  const auto off = [&](int vertices, int face_count) {
    return fmt::format("OFF\n{} {} 0\n{}{}", vertices, face_count, corners, faces);
  };
  const auto read = [&](const char* name, const std::string& text) {
    return read_surface(folder.write(name, text));
  };
  const auto refused = [&](const char* name, const std::string& text) {
    return error_of([&] { read(name, text); });
  };
  CHECK(read("a.ply", ply(4, 1, 4)).remarks.empty());
  CHECK_THAT(refused("a.ply", ply(5, 1, 4)),
             Contains("a.ply:17: fewer numbers than one vertex has, of which the header announces 5"));
  CHECK_THAT(refused("a.ply", ply(5, 0, 4)), Contains("a.ply:17: more numbers than one vertex has"));
  CHECK_THAT(refused("a.ply", ply(3, 1, 4)), Contains("a.ply:16: more numbers than one edge has"));
  CHECK_THAT(refused("a.ply", ply(4, 1, 5)), Contains("a.ply", "ends where"));
  const Surface fewer = read("a.ply", ply(4, 1, 3));
  REQUIRE(fewer.remarks.size() == 1);
  CHECK_THAT(fewer.remarks[0], Contains("line 21: 1 line behind the last element is left out"));
  CHECK(read("a.off", off(4, 4) + "\n# end\n").remarks.empty());
  CHECK_THAT(refused("a.off", off(4, 5)), Contains("a.off", "ends where"));
  CHECK_THAT(refused("a.off", off(5, 4)), Contains("a.off", "ends where"));
  const Surface open = read("a.off", off(4, 2));
  CHECK(open.triangles.size() == 2);
  REQUIRE(open.remarks.size() == 1);
  CHECK_THAT(open.remarks[0], Contains("line 9: 2 lines behind the last face are left out"));
}

TEST_CASE("PLY: bytes behind the last element are left out, and counted") {
  const TemporaryFolder folder;
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
    text.append(reinterpret_cast<const char*>(&number), sizeof number);
  text += std::string("\3\0\1\2", 4);
  CHECK(read_surface(folder.write("a.ply", text)).remarks.empty());
  const Surface longer = read_surface(folder.write("b.ply", text + "12345"));
  CHECK(longer.triangles.size() == 1);
  REQUIRE(longer.remarks.size() == 1);
  CHECK_THAT(longer.remarks[0], Contains("5 bytes behind the last element"));
}

TEST_CASE("formats of other programs are refused with the tool that converts them") {
  const TemporaryFolder folder;
  CHECK_THAT(error_of([&] { read_mesh(folder.write("a.inp", "*NODE\n")); }), Contains("meshio convert"));
  CHECK_THAT(error_of([&] { read_mesh(folder.write("a.feb", "<febio_spec/>")); }), Contains("FEBio Studio"));
  CHECK_THAT(error_of([&] { read_mesh(folder.write("a.step", "ISO")); }), Contains("gmsh -3"));
}

TEST_CASE("Gmsh: a binary section that is not needed ends with or without a line break") {
  const TemporaryFolder folder;
  const auto file = [](const std::string& before_end) {
    std::string text = "$MeshFormat\n2.2 1 8\n";
    const auto put = [&](auto value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
    put(std::int32_t{1});
    text += "\n$EndMeshFormat\n$Nodes\n4\n";
    for (std::int32_t i = 0; i < 4; ++i) {
      put(i + 1);
      for (int axis = 0; axis < 3; ++axis) put(i == axis + 1 ? 1.0 : 0.0);
    }
    text += "$EndNodes\n$Elements\n1\n";
    for (const std::int32_t number : {4, 1, 2, 1, 1, 1, 1, 2, 3, 4}) put(number);
    text += "$EndElements\n$ElementData\n1\n\"$EndElementData\"\n1\n0\n3\n0\n1\n1\n";
    put(std::int32_t{1});
    put(2.5);
    return text + before_end + "$EndElementData\n";
  };
  for (const char* before : {"", "\n"}) {
    const TetMesh mesh = read_mesh(folder.write("a.msh", file(before)));
    CHECK(mesh.tets.size() == 1);
    CHECK(mesh.nodes.size() == 4);
  }
  std::string cut = file("");
  cut.resize(cut.size() - 12);
  CHECK_THAT(error_of([&] { read_mesh(folder.write("a.msh", cut)); }), Contains("$ElementData has no end"));
}
