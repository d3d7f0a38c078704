// Meshes as Gmsh and people write them: nodes of no element, elements listed once for each group, mixed node order,
// parts joined by a node or an edge. Each fault is tried on ten variants of a seed (other sizes, units, axes, order of
// nodes and elements), against the same body without the fault.
#include <fmt/format.h>

#include "apps/scene/scene.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/solver/block_body.hpp"
#include "tests/support/executable.hpp"

namespace {

struct Variant {
  std::mt19937 random;
  Vec3 size;
  TetMesh mesh;
  Vec3 press;  // [m]
  std::string axis;

  explicit Variant(unsigned seed) : random(seed) {
    const double unit = std::pow(10.0, static_cast<int>(whole(0, 2)) - 1);
    size = unit * Vec3(real(0.05, 0.15), real(0.05, 0.15), real(0.05, 0.15));
    mesh = block_mesh(whole(2, 3), whole(2, 3), whole(2, 3), size);
    const int turn = whole(0, 2);
    axis = "xyz"[turn];
    for (Vec3& node : mesh.nodes) node = turned(node, turn);
    press = 0.05 * unit * turned(Vec3(-0.1, 0.02, 0.05), turn);
    shuffle();
  }
  static Vec3 turned(const Vec3& x, int turn) { return {x[turn], x[(turn + 1) % 3], x[(turn + 2) % 3]}; }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  // Nodes and tetrahedra in any order.
  void shuffle() {
    std::vector<NodeIndex> place(mesh.nodes.size());
    std::iota(place.begin(), place.end(), 0u);
    std::shuffle(place.begin(), place.end(), random);
    std::vector<Vec3> nodes(place.size());
    for (std::size_t i = 0; i < place.size(); ++i) nodes[place[i]] = mesh.nodes[i];
    mesh.nodes = std::move(nodes);
    for (Tet& tet : mesh.tets)
      for (NodeIndex& node : tet) node = place[node];
    std::shuffle(mesh.tets.begin(), mesh.tets.end(), random);
  }
  // A node of no element, at any place in the order.
  void add_lonely_node(const Vec3& at) {
    const auto place = static_cast<NodeIndex>(whole(0, static_cast<int>(mesh.nodes.size())));
    mesh.nodes.insert(mesh.nodes.begin() + place, at);
    for (Tet& tet : mesh.tets)
      for (NodeIndex& node : tet) node += node >= place;
    for (auto& [name, nodes] : mesh.groups)
      for (NodeIndex& node : nodes) node += node >= place;
  }
  // Clamped at the low end of the axis, pressed at the other.
  std::string scene(const std::string& more = "") const {
    const Box box = bounding_box(mesh);
    const Vec3& tip = box.high;
    const double least = box.size().minCoeff(), reach = 0.2 * least;
    return fmt::format(
        "[body]\nmesh = \"body.msh\"\nelement = \"linear\"\n{}\n[material]\nlaw = \"neo-hookean\"\n"
        "young = 1e4\npoisson = 0.3\n[state_space]\nspacing = {}\nbox = [[-{}, -{}, -{}], [{}, {}, {}]]\n"
        "[clamp]\nbelow = {{ axis = \"{}\", share = 0.1 }}\n"
        "[contact]\nnearest = [{}, {}, {}]\nradius = {}\n",
        more, reach / 4, reach, reach, reach, reach, reach, reach, axis, tip[0], tip[1], tip[2], 0.6 * least);
  }
};

// A .msh file of format 2.2 as Gmsh writes it; groups of a tetrahedron list it again.
std::string msh(const TetMesh& mesh, const std::vector<std::vector<int>>& groups = {}) {
  std::string elements;
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (const int group : groups.empty() ? std::vector<int>{1} : groups[t]) {
      const Tet& tet = mesh.tets[t];
      elements += fmt::format("{} 4 2 {} {} {} {} {} {}\n", ++count, group, group, tet[0] + 1, tet[1] + 1,
                              tet[2] + 1, tet[3] + 1);
    }
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"tissue\"\n3 2 \"tumour\"\n"
      "$EndPhysicalNames\n$Nodes\n" +
      fmt::format("{}\n", mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    text += fmt::format("{} {} {} {}\n", i + 1, mesh.nodes[i].x(), mesh.nodes[i].y(), mesh.nodes[i].z());
  return text + fmt::format("$EndNodes\n$Elements\n{}\n{}$EndElements\n", count, elements);
}

Vec3 force_of(const Scene& scene, const Vec3& press) {
  Solver solver(scene.body);
  const SolveOutcome outcome = solver.reference(press, 1.0);
  REQUIRE(outcome.state.solve.status == SolveStatus::converged);
  return outcome.state.force;
}

bool warned(const Scene& scene, const std::string& words) {
  return std::ranges::any_of(scene.source.warnings, [&](const std::string& warning) {
    return warning.find(words) != std::string::npos;
  });
}

}  // namespace

TEST_CASE(
    "nodes of no element are no part of the body: extent, clamp share, length, nearest, groups, summary") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Variant variant(seed);
    const Workshop shop;
    const TetMesh clean = variant.mesh;
    const double side = longest_side(clean);
    const std::string text = variant.scene(), scaled = variant.scene(fmt::format("length = {}", side));
    shop.write("body.msh", msh(clean));
    const Vec3 expected = force_of(load_scene(shop.write("scene.toml", text), {}), variant.press);
    const int lonely = variant.whole(1, 4);
    for (int k = 0; k < lonely; ++k)
      variant.add_lonely_node(bounding_box(clean).centre() +
                              side * Vec3(variant.real(-9, 9), variant.real(-9, 9), variant.real(-9, 9)));
    variant.mesh.groups["some"] = {};
    for (NodeIndex i = 0; i < variant.mesh.nodes.size(); ++i) variant.mesh.groups["some"].push_back(i);
    shop.write("body.msh", msh(variant.mesh));
    for (const std::string& scene_text : {text, scaled}) {
      const Scene scene = load_scene(shop.write("scene.toml", scene_text), {});
      CHECK((force_of(scene, variant.press) - expected).norm() < 1e-9 * expected.norm());
      CHECK(warned(scene, "to no tetrahedron and"));
      CHECK((bounding_box(scene.body->mesh).size() - bounding_box(clean).size()).norm() < 1e-12 * side);
      CHECK(surface_nodes(scene.body->mesh).size() == surface_nodes(clean).size());
    }
    TetMesh mesh = variant.mesh;
    check_and_orient(mesh, "body.msh");
    CHECK(mesh.groups.at("some").size() == clean.nodes.size());
    const MeshSummary sum = summarise(mesh);
    CHECK(sum.nodes == clean.nodes.size());
    CHECK((sum.box.size() - bounding_box(clean).size()).norm() == 0);
    CHECK(nodes_below(mesh, Axis::x, 1).size() == clean.nodes.size());
  }
}

TEST_CASE("an element that is listed once for each of its groups is one element of all of them") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Variant variant(seed);
    const Workshop shop;
    const TetMesh clean = variant.mesh;
    const std::string materials =
        "[[material]]\nlaw = \"neo-hookean\"\nyoung = 1e4\npoisson = 0.3\n[[material]]\ngroup = \"tumour\"\n"
        "law = \"neo-hookean\"\nyoung = 6e4\npoisson = 0.2\n";
    std::string text = variant.scene();
    text.replace(text.find("[material]"), text.find("[state_space]") - text.find("[material]"), materials);
    std::vector<std::vector<int>> once(clean.tets.size(), {1}), each = once;
    std::vector<TetIndex> tumour;
    for (std::size_t t = 0; t < once.size(); ++t)
      if (variant.whole(0, 2) == 0)
        once[t] = {2}, each[t] = {1, 2}, tumour.push_back(static_cast<TetIndex>(t));
    shop.write("body.msh", msh(clean, once));
    const Vec3 expected = force_of(load_scene(shop.write("scene.toml", text), {}), variant.press);
    shop.write("body.msh", msh(clean, each));
    const Scene scene = load_scene(shop.write("scene.toml", text), {});
    CHECK(scene.body->mesh.tets.size() == clean.tets.size());
    CHECK(scene.body->mesh.element_groups.at("tumour") == tumour);
    CHECK(scene.body->mesh.element_groups.at("tissue").size() == clean.tets.size());
    CHECK((force_of(scene, variant.press) - expected).norm() < 1e-9 * expected.norm());
    CHECK_FALSE(warned(scene, "listed twice"));
    // In any order.
    std::vector<std::pair<Tet, int>> rows;
    for (std::size_t e = 0; e < each.size(); ++e)
      for (const int group : each[e]) rows.emplace_back(clean.tets[e], group);
    std::shuffle(rows.begin(), rows.end(), variant.random);
    TetMesh listed = clean;
    listed.tets.clear();
    std::vector<std::vector<int>> of;
    for (const auto& [tet, group] : rows) listed.tets.push_back(tet), of.push_back({group});
    shop.write("body.msh", msh(listed, of));
    const Scene shuffled = load_scene(shop.write("scene.toml", text), {});
    CHECK(shuffled.body->mesh.tets.size() == clean.tets.size());
    CHECK((force_of(shuffled, variant.press) - expected).norm() < 1e-9 * expected.norm());
    // The same element twice in one group is one, too, with a word.
    const auto t = static_cast<std::size_t>(variant.whole(0, static_cast<int>(clean.tets.size()) - 1));
    once[t] = {once[t][0], once[t][0]};
    shop.write("body.msh", msh(clean, once));
    const Scene twice = load_scene(shop.write("scene.toml", text), {});
    CHECK(warned(twice, "1 tetrahedron was listed twice"));
    CHECK((force_of(twice, variant.press) - expected).norm() < 1e-9 * expected.norm());
  }
}

TEST_CASE("tetrahedra in mixed node order are turned, and a tangled mesh is refused") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Variant variant(seed);
    const Workshop shop;
    const std::string text = variant.scene();
    shop.write("body.msh", msh(variant.mesh));
    const Vec3 expected = force_of(load_scene(shop.write("scene.toml", text), {}), variant.press);
    TetMesh mixed = variant.mesh;
    std::size_t turned = 0;
    for (std::size_t t = 0; t < mixed.tets.size(); ++t) {
      const bool turn = t == 0 || (t > 1 && variant.whole(0, 3) == 0);
      const auto a = static_cast<std::size_t>(variant.whole(0, 3)), b = (a + 1) % 4;
      if (turn) std::swap(mixed.tets[t][a], mixed.tets[t][b]), ++turned;
    }
    shop.write("body.msh", msh(mixed));
    const Scene scene = load_scene(shop.write("scene.toml", text), {});
    CHECK((force_of(scene, variant.press) - expected).norm() < 1e-9 * expected.norm());
    CHECK(warned(scene, fmt::format("{} of {} tetrahedra w", turned, mixed.tets.size())));
    CHECK(mesh_quality(scene.body->mesh).min_tet_volume > 0);
    // A node pulled through the opposite faces of its elements.
    const auto node = variant.mesh.tets[0][0];
    mixed = variant.mesh;
    mixed.nodes[node] += 1.3 * (bounding_box(mixed).centre() - mixed.nodes[node]) +
                         longest_side(mixed) * Vec3(0.71, 0.53, 0.91);
    shop.write("body.msh", msh(mixed));
    CHECK_THAT(error_of([&] { load_scene(shop.path() / "scene.toml", {}); }), Contains("overlap", "tangled"));
  }
}

TEST_CASE("a part that hangs by a node or an edge is named as one that can turn") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    Variant variant(seed);
    const Workshop shop;
    const std::string text = variant.scene();
    // Another block, whose corner or edge is one of the first block: in the plane of the far end of the axis.
    const bool edge = seed % 2 == 1;
    const int axis = variant.axis == "x" ? 0 : variant.axis == "y" ? 1 : 2;
    const Box box = bounding_box(variant.mesh);
    TetMesh other = block_mesh(2, 2, 2, box.size());
    Vec3 shift = box.size();
    if (edge) shift[(axis + 1) % 3] = 0;
    for (Vec3& at : other.nodes) at += box.low + shift;
    if (edge)  // the nodes of the edge must be the same: both blocks are cut anew
      variant.mesh = block_mesh(2, 2, 2, box.size());
    TetMesh joined = variant.mesh;
    std::vector<NodeIndex> number;
    std::size_t common = 0;
    for (const Vec3& at : other.nodes) {
      const auto same = std::ranges::find_if(
          joined.nodes, [&](const Vec3& x) { return (x - at).norm() < 1e-9 * box.size().norm(); });
      common += same != joined.nodes.end();
      number.push_back(static_cast<NodeIndex>(same - joined.nodes.begin()));
      if (same == joined.nodes.end()) joined.nodes.push_back(at);
    }
    REQUIRE(common == (edge ? 3 : 1));
    for (Tet tet : other.tets) {
      for (NodeIndex& node : tet) node = number[node];
      joined.tets.push_back(tet);
    }
    shop.write("body.msh", msh(joined));
    // The contact is on the first block alone, off what is joined.
    const Vec3 tip =
        box.centre() + Vec3(Variant::turned(Vec3(0.45, 0, 0), (3 - axis) % 3).cwiseProduct(box.size()));
    std::string hinged = variant.scene();
    hinged = hinged.substr(0, hinged.find("below = ")) +
             fmt::format("below = {{ axis = \"{}\", share = 0.04 }}\n[contact]\nnearest = [{}, {}, {}]\n",
                         variant.axis, tip[0], tip[1], tip[2]);
    shop.write("scene.toml", hinged);
    CHECK_THAT(error_of([&] { load_scene(shop.path() / "scene.toml", {}); }),
               Contains("part 2 of the mesh (48 tetrahedra) hangs on " +
                        std::string(edge ? "3 nodes of one line" : "1 node") + ": it can turn freely"));
    TetMesh looked = joined;
    const auto said = check_and_orient(looked, "body.msh").warnings;
    REQUIRE(said.size() == 1);
    CHECK_THAT(said[0], Contains("2 parts that hang together by single nodes or edges only"));
    // Held by itself, the part is a body like another.
    Body body;
    body.mesh = joined;
    body.clamp = nodes_below(joined, Axis(axis), 0.04);
    for (const NodeIndex node : std::vector<NodeIndex>{number[26], number[25], number[23], number[17]})
      body.clamp.push_back(node);
    std::ranges::sort(body.clamp);
    body.contact = {nearest_surface_node(variant.mesh, tip)};
    CHECK_NOTHROW(check(body, "scene.toml"));
  }
}
