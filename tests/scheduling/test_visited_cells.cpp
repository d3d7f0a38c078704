#include "scheduling/judge/visited_cells.hpp"
#include "tests/support/test.hpp"

TEST_CASE("Cells are visited once, and those that leave the box not at all") {
  VisitedCells cells({Vec3::Constant(-0.036), Vec3::Constant(0.036)}, 0.006);
  CHECK(cells.first(Vec3(0.001, 0.001, 0.001)));
  CHECK_FALSE(cells.first(Vec3(0.005, 0.002, 0.003)));
  CHECK(cells.first(Vec3(-0.001, 0.002, 0.003)));
  CHECK(cells.first(Vec3(0.0359, 0, 0)));  // its far face is the box's own
  CHECK_FALSE(cells.first(Vec3(0.0361, 0, 0)));
  CHECK(cells.count() == 3);
}
