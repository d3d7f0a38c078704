// The field of a scene with contact.anywhere: its keys, what the cache keeps of it, and the fine body.

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_fine.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/executable.hpp"

namespace {

// The beam of 10 x 2 x 2 cm, clamped at x = 0.
const std::string beam =
    "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
    "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n";
const Globals quiet{.quiet = true, .set = {}};

Scene load(const Workshop& shop, const std::vector<std::string>& overrides = {}) {
  return load_scene_with_sites(shop.write("beam.toml", beam), overrides, {.spacing = false, .quiet = true});
}

fs::path only_field() {
  fs::path found;
  for (const auto& entry : fs::directory_iterator(cache_folder()))
    if (entry.path().extension() == ".sites") {
      CHECK(found.empty());
      found = entry.path();
    }
  return found;
}

Vec3 force_of(const SiteField& field, const Vec3& near, const Vec3& x) {
  return field.at(field.rest().map().nearest(near), false).at(x).force;
}

const Vec3 top(0.07, 0.008, 0.021), pressed(0.001, 0.002, -0.004);

}  // namespace

TEST_CASE("friction, spacing of sites and depth are what the scene gives", "[scene]") {
  const Workshop shop;
  const Scene plain = load(shop),
              scene =
                  load(shop, {"contact.friction=0.4", "contact.site_spacing=0.02", "state_space.depth=0.01"});
  REQUIRE(plain.touch.anywhere);
  CHECK(plain.touch.anywhere->friction == 0.2);
  CHECK_FALSE(load(shop, {"contact.bonded=true"}).touch.anywhere->friction);
  CHECK_FALSE(plain.touch.anywhere->site_spacing);
  CHECK(plain.touch.anywhere->depth == usual_depth);
  CHECK(scene.touch.anywhere->friction == 0.4);
  CHECK(scene.touch.anywhere->site_spacing == 0.02);
  CHECK(scene.touch.anywhere->depth == 0.01);
  CHECK(scene.space.box.high == Vec3::Constant(0.01));
  CHECK(site_field_of(scene, quiet)->options().spacing == 0.02);
  CHECK(site_field_of(scene, quiet)->size() < site_field_of(plain, quiet)->size());
}

TEST_CASE("a field is kept in the cache, to the bit, and made anew where its file is altered", "[scene]") {
  const Workshop shop;
  empty_cache(cache_folder());
  const Scene scene = load(shop);
  const FieldFound made = find_field(scene, quiet), kept = find_field(scene, quiet);
  CHECK_FALSE(made.kept);
  REQUIRE(kept.kept);
  CHECK(kept.field->size() == made.field->size());
  const Vec3 force = force_of(*made.field, top, pressed);
  CHECK(force.norm() > 0.01);
  CHECK(force_of(*kept.field, top, pressed) == force);
  const fs::path file = only_field();
  REQUIRE_FALSE(file.empty());
  {
    std::fstream change(file, std::ios::in | std::ios::out | std::ios::binary);
    change.seekp(1000);
    change.put('!');
  }
  const FieldFound again = find_field(scene, quiet);
  CHECK_FALSE(again.kept);
  CHECK(force_of(*again.field, top, pressed) == force);
  CHECK(find_field(scene, quiet).kept);
  CHECK_FALSE(find_field(load(shop, {"contact.radius=0.013"}), quiet).kept);
  CHECK_FALSE(find_field(load(shop, {"material.young=5001"}), quiet).kept);
  CHECK(empty_cache(cache_folder()).foreign == 0);
  CHECK_FALSE(find_field(scene, quiet).kept);
}

TEST_CASE("a field that is stopped is not kept", "[scene]") {
  const Workshop shop;
  empty_cache(cache_folder());
  std::stop_source stop;
  stop.request_stop();
  CHECK(find_field(load(shop), quiet, stop.get_token()).field->size() == 0);
  CHECK_FALSE(find_field(load(shop), quiet).kept);
}

TEST_CASE("with a fine body the field is that of the fine body, and so is a state near rest", "[scene]") {
  const Workshop shop;
  const Scene scene = load(shop, {"body.fine={elements=700}"});
  REQUIRE(scene.touch.anywhere->fine);
  CHECK(scene.identity.at("fine") != "");
  CHECK_FALSE(scene.body->fine);
  const auto field = site_field_of(scene, quiet);
  CHECK(field->rest().body().element == Element::quadratic);
  const SitedBody sited = put_at(scene, top);
  REQUIRE(sited.body->fine);
  const Vec3 x = 0.25 * pressed;
  const Vec3 state = Solver(sited.body).reference(x, 0.006).state.force;
  Body fine = scene.touch.anywhere->fine->first;
  fine.pad->site = sited.body->pad->site;
  const Vec3 of_fine = Solver(std::move(fine)).reference(x, 0.006).state.force;
  CHECK((state - of_fine).norm() < 2e-3 * of_fine.norm());
  CHECK((force_of(*field, top, x) - of_fine).norm() < 2e-3 * of_fine.norm());
  CHECK((force_of(*site_field_of(load(shop), quiet), top, x) - of_fine).norm() > 0.02 * of_fine.norm());
}

TEST_CASE("a map of stiffness weighs by area and shows that a clamped end is stiff", "[scene]") {
  const Workshop shop;
  const Scene scene = load(shop);
  const RestSites rest(scene.body, 1);
  const std::vector<SurfaceStiffness> map = palpation_map(rest, *scene.body, 1);
  double area = 0, near = 0, far = 1e300;
  for (const SurfaceStiffness& at : map) {
    area += at.area;
    CHECK(at.with_pad < at.alone);
    const double x = scene.body->mesh.nodes[at.node].x();
    if (x < 0.03) near = std::max(near, at.alone);
    if (x > 0.09) far = std::min(far, at.alone);
  }
  CHECK(area < rest.map().free_area());
  CHECK(area > 0.8 * rest.map().free_area());
  CHECK(near > 2 * far);
  const auto range = range_over(map, &SurfaceStiffness::alone);
  REQUIRE(range);
  CHECK(range->least <= far);
  CHECK(range->least < range->median);
  CHECK(range->median < range->greatest);
  CHECK(range->greatest >= near);
  const std::vector<SurfaceStiffness> three{{0, 1, 5, 1}, {1, 10, 7, 2}, {2, 1, 9, 3}};
  CHECK(range_over(three, &SurfaceStiffness::with_pad)->median == 7);
  CHECK_FALSE(range_over({}, &SurfaceStiffness::alone));
}
