#include "geometry/meshing/phantom.hpp"
#include "tests/support/test.hpp"

TEST_CASE("phantoms have the wanted number of elements and pass the checks") {
  for (const std::string& name : phantom_names())
    for (const std::size_t elements : {0ul, 600ul, 3000ul, 9000ul}) {
      INFO(name << " " << elements);
      TetMesh mesh = phantom(name, elements);
      const double asked = elements != 0     ? double(elements)
                           : name == "liver" ? 1777
                                             : double(mesh.tets.size());
      CHECK(std::abs(double(mesh.tets.size()) / asked - 1) <= 0.05);
      CHECK(check_and_orient(mesh, name).warnings.empty());
      CHECK(mesh_quality(mesh).min_dihedral_deg > 7);
      const auto &clamp = mesh.groups.at("clamp"), &contact = mesh.groups.at("contact");
      REQUIRE(!clamp.empty());
      REQUIRE(!contact.empty());
      std::vector<NodeIndex> both;
      std::ranges::set_intersection(clamp, contact, std::back_inserter(both));
      CHECK(both.empty());
    }
}

TEST_CASE("the liver is 22 cm long, held below and touched on top of its thick lobe") {
  const TetMesh mesh = phantom("liver");
  const Box box = bounding_box(mesh);
  CHECK(longest_side(mesh) == Approx(0.22).epsilon(1e-9));
  const Vec3 tip = phantom_tip("liver");
  const Vec3 nearest = mesh.nodes[std::size_t(nearest_surface_node(mesh, tip))];
  CHECK((nearest - tip).norm() < 1e-9);  // a node lies on the tip
  CHECK(box.high.z() - tip.z() < 0.002);
  CHECK(tip.z() - box.low.z() > 2 * 0.036);  // a press of 3.6 cm leaves more than half
  for (const NodeIndex node : mesh.groups.at("clamp"))
    CHECK(mesh.nodes[std::size_t(node)].z() < box.low.z() + 0.03);
  for (const NodeIndex node : mesh.groups.at("contact"))
    CHECK((mesh.nodes[std::size_t(node)] - tip).norm() <= 0.02);
  CHECK(mesh.groups.at("contact").size() >= 5);
}

TEST_CASE("a phantom is the same each time") {
  const TetMesh a = phantom("liver"), b = phantom("liver");
  CHECK(a.nodes == b.nodes);
  CHECK(a.tets == b.tets);
}

TEST_CASE("volumes against exact ones") {
  CHECK(mesh_quality(phantom("beam")).volume == Approx(4e-5).epsilon(1e-12));
  CHECK(mesh_quality(phantom("slab")).volume == Approx(1.6e-3).epsilon(1e-12));
  // An inscribed polyhedron misses the ball by O(h^2): eight times the elements, a quarter of the error.
  const double exact = 4.0 / 3 * std::numbers::pi * std::pow(0.05, 3);
  const double coarse = 1 - mesh_quality(phantom("ball", 1000)).volume / exact,
               fine = 1 - mesh_quality(phantom("ball", 8000)).volume / exact;
  CHECK(coarse > 0);
  CHECK(fine > 0);
  CHECK(coarse / fine == Approx(4).epsilon(0.2));
}

TEST_CASE("an unknown phantom lists the known ones") {
  CHECK_THROWS_WITH(phantom("kidney"), Contains("liver, beam, ball, slab"));
  CHECK_THROWS_AS(phantom("beam", 1), InputError);
}
