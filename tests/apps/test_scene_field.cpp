// The field of a scene with contact.anywhere: its keys, what the cache keeps of it, and the fine body.

#include "apps/console/console.hpp"
#include "apps/scene/cache_folder.hpp"
#include "apps/scene/kept_pieces.hpp"
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

TEST_CASE("pieces of a killed run are read to the last whole one, and one process at a time keeps them",
          "[scene]") {
  const Workshop shop;
  const fs::path file = shop.path() / "pieces";
  const std::vector<double> a{1, 2.5, -3}, b{4};
  std::vector<double> three(3), one(1);
  {
    PieceFile pieces(file);
    pieces.keep(7, a);
    pieces.keep(1, b);
    PieceFile other(file);
    other.keep(2, b);
    CHECK(other.size() == 0);
  }
  {
    PieceFile pieces(file);
    CHECK(pieces.size() == 2);
    CHECK_FALSE(pieces.take(7, one));  // of another length
    REQUIRE(pieces.take(7, three));
    CHECK(three == a);
    CHECK_FALSE(pieces.take(7, three));
    CHECK_FALSE(pieces.take(2, one));
  }
  fs::resize_file(file, fs::file_size(file) - 1);
  {
    PieceFile pieces(file);
    CHECK(pieces.size() == 1);
    pieces.keep(3, b);  // after the last whole one
  }
  PieceFile pieces(file);
  CHECK((pieces.take(3, one) && one == b && pieces.take(7, three)));
  pieces.remove();
  CHECK_FALSE(fs::exists(file));
  PieceFile nowhere{fs::path()};
  nowhere.keep(1, b);
  CHECK_FALSE(nowhere.take(1, one));
}

TEST_CASE("a field resumes from the pieces of a run that was killed, to the bit", "[scene]") {
  struct Counted final : KeptPieces {
    explicit Counted(const fs::path& path) : file(path) {}
    bool take(std::uint64_t piece, std::span<double> values) override { return file.take(piece, values); }
    void keep(std::uint64_t piece, std::span<const double> values) override {
      ++made;
      file.keep(piece, values);
    }
    PieceFile file;
    std::size_t made = 0;
  };
  const Workshop shop;
  const Scene scene = load(shop);
  const SiteFieldOptions options{.threads = 2};
  const fs::path file = shop.path() / "pieces";
  std::vector<double> shares;
  const auto make = [&](Counted* kept) {
    shares.clear();
    const auto show = [&](double share) { shares.push_back(share); };
    const auto rest = std::make_shared<const RestSites>(scene.body, 2, std::span<const double>(), show, kept);
    return std::make_shared<const SiteField>(rest, options, show, std::stop_token(), kept);
  };
  const auto values = [](std::shared_ptr<const SiteField> field, KeptPieces* kept) {
    return FieldPatches(std::move(field), {}, {}, {}, kept).values();
  };
  std::size_t all = 0;
  std::shared_ptr<const SiteField> first;
  {
    Counted kept(file);
    first = make(&kept);
    all = kept.made;
    CHECK(all > first->size());
    CHECK(shares.front() == 0);
    CHECK(shares.back() == 1);
  }
  fs::resize_file(file, fs::file_size(file) / 2);
  {
    Counted kept(file);
    const auto again = make(&kept);
    CHECK(kept.made > 0);
    CHECK(kept.made < 0.9 * static_cast<double>(all));
    REQUIRE(again->size() == first->size());
    CHECK(again->rest().compliance() == first->rest().compliance());
    for (std::size_t i = 0; i < first->size(); ++i) CHECK(again->stiffness(i) == first->stiffness(i));
    CHECK(force_of(*again, top, pressed) == force_of(*first, top, pressed));
  }
  Counted kept(file);
  CHECK(make(&kept)->size() == first->size());
  CHECK(kept.made == 0);
  CHECK(shares == std::vector<double>{1, 1});  // of the compliance and of the sites: what is there
  const std::vector<double> patches = values(first, &kept);
  CHECK(kept.made > 0);
  const std::size_t before = kept.made;
  Counted after(file.string() + ".other");
  CHECK(values(first, &after) == patches);
  CHECK(after.made == before);
}

TEST_CASE("a field whose run was killed is finished from the cache", "[scene]") {
  const Workshop shop;
  empty_cache(cache_folder());
  const Scene scene = load(shop);
  const FieldFound made = find_field(scene, quiet);
  const fs::path file = only_field(), part = file.string() + ".part";
  CHECK_FALSE(fs::exists(part));
  fs::remove(file);
  {  // as a killed run leaves it
    PieceFile pieces(part);
    const RestSites rest(scene.body, 1, {}, {}, &pieces);
  }
  const auto before = fs::file_size(part);
  CHECK(before > 1000);
  CHECK(cache_content(cache_folder()).foreign == 0);
  const FieldFound again = find_field(scene, quiet);
  CHECK(force_of(*again.field, top, pressed) == force_of(*made.field, top, pressed));
  CHECK_FALSE(fs::exists(part));
  CHECK(find_field(scene, quiet).kept);
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
