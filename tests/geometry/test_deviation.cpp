// Warnings about a mesh that deviates from its surface.

#include "geometry/meshing/deviation.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

TEST_CASE(
    "a mesh with a twentieth less volume, or off by a twentieth of its length, is said with what to do") {
  const TetMesh ball = phantom("ball", 300);
  const Surface same = boundary_surface(ball);
  const Deviation none = deviation_of(same, ball, 0);
  CHECK(none.volume_change == Approx(0).margin(1e-12));
  CHECK(in_words(none, {}).empty());
  // The volume of the cube around the ball is 6 / pi times that of the ball.
  Surface cube = test::unit_cube();
  const Box box = bounding_box(ball);
  for (Vec3& node : cube.nodes) node = box.low + node.cwiseProduct(box.size());
  const Deviation lost = deviation_of(cube, ball, 0.2 * longest_side(ball));
  CHECK(lost.volume_change == Approx(-0.5).margin(0.08));
  const auto words = in_words(lost, {});
  REQUIRE(words.size() == 2);
  CHECK_THAT(words[0], Contains("% less volume than the surface; more elements"));
  CHECK_THAT(words[1], Contains("20 % of its longest side; more elements"));
  CHECK_THAT(in_words(lost, {.self_intersections = 3})[0],
             Contains("whose overlapping parts count twice; mend the surface"));
  // A scaled mesh is compared with the scaled surface.
  TetMesh larger = ball;
  scale_to_length(larger, 2);
  CHECK(deviation_of(same, larger, 0, 2.0).volume_change == Approx(0).margin(1e-9));
  // A mesh without the surface's ends is smaller than the surface, and not at another scale.
  TetMesh smaller = ball;
  for (Vec3& node : smaller.nodes) node *= 0.9;
  CHECK(deviation_of(same, smaller, 0).volume_change == Approx(0.729 - 1).epsilon(1e-9));
  // An open surface has no volume.
  Surface open = same;
  open.triangles.pop_back();
  CHECK(std::isnan(deviation_of(open, ball, 0).volume_change));
}
