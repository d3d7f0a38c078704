// body.accuracy: the body that a scene gets for a relative error of the force.

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_accuracy.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/executable.hpp"

namespace {

const std::string rest = R"([material]
law = "neo-hookean"
young = 5000.0
poisson = 0.4
[clamp]
group = "clamp"
[contact]
pad = 1000.0
[state_space]
spacing = 0.01
box = [[-0.02, -0.02, -0.02], [0.02, 0.02, 0.02]]
)";

Scene load(const Workshop& shop, const std::string& body, const std::vector<std::string>& overrides = {}) {
  return load_scene(shop.write("scene.toml", "[body]\n" + body + rest), overrides, nullptr, {.quiet = true});
}

}  // namespace

TEST_CASE("the least costly body that meets body.accuracy is taken, and its error is true",
          "[scene]" SLOW("solves bodies of up to 6,000 quadratic elements")) {
  const Workshop shop;
  const std::string ball = "phantom = \"ball\"\nelements = 400\n";
  const Scene coarse = load(shop, ball + "accuracy = 0.2\n"), fine = load(shop, ball + "accuracy = 0.03\n");
  REQUIRE(coarse.source.accuracy);
  REQUIRE(fine.source.accuracy);
  CHECK(coarse.source.accuracy->reached);
  CHECK(fine.source.accuracy->reached);
  CHECK(fine.source.accuracy->high <= 0.03);
  REQUIRE(fine.body->fine);
  CHECK(fine.body->element == fine.source.accuracy->taken.element);
  CHECK(fine.source.accuracy->seconds > 0);
  CHECK(fine.source.accuracy->ms_per_state > 0);
  // a solved body of quadratic elements, more than the fine body has
  const Scene truth = load(shop, "phantom = \"ball\"\nelements = 6000\nelement = \"quadratic\"\n");
  const Vec3 x = 0.02 * truth.inward;
  const Vec3 force = Solver(truth.body).reference(x, 0.02, {.tolerance = 1e-7}).state.force;
  CHECK((Solver(fine.body).reference(x, 0.01).state.force - force).norm() < 0.03 * force.norm());
}

TEST_CASE("the first of the trials that meets the wanted error is taken, and dearer ones are not tried",
          "[scene]" SLOW("makes and solves a body for each trial")) {
  const Workshop shop;
  const std::vector<AccuracyTrial> trials{
      {Element::linear, 200, 0}, {Element::quadratic, 200, 0}, {Element::quadratic, 600, 0}};
  int made = 0;
  const BodyMaker maker{
      [&](const AccuracyTrial& trial) {
        ++made;
        const std::string element = trial.element == Element::linear ? "linear" : "quadratic";
        return *load(shop, "phantom = \"ball\"\nfine = false\nelements = " + std::to_string(trial.elements) +
                               "\nelement = \"" + element + "\"\n")
                    .body;
      },
      [](const Body&) { return Vec3(0, 0, -1); }};
  const AccuracyChoice rough = choose_accuracy(1.0, trials, "rough", maker);
  CHECK(rough.reached);
  CHECK(rough.taken.element == Element::linear);
  CHECK(made == 1);
  const AccuracyChoice better = choose_accuracy(0.5 * rough.high, trials, "better", maker);
  CHECK(better.reached);
  CHECK(better.taken.element == Element::quadratic);
  CHECK(better.high <= 0.5 * rough.high);
  CHECK(better.taken.elements == trials[static_cast<std::size_t>(made) - 2].elements);
}

TEST_CASE("the choice of body.accuracy is kept, and keys beside it win",
          "[scene]" SLOW("makes and solves a body for each trial")) {
  const Workshop shop;
  const std::string ball = "phantom = \"ball\"\naccuracy = 0.1\nelements = 400\n";
  const Scene first = load(shop, ball), again = load(shop, ball);
  REQUIRE(first.source.accuracy);
  CHECK(again.source.accuracy->seconds == first.source.accuracy->seconds);  // not searched again
  CHECK(again.identity == first.identity);
  CHECK(std::abs(static_cast<double>(first.body->mesh.tets.size()) - 400) < 0.05 * 400);
  const Scene given = load(shop, ball, {"body.fine={elements=700}", "body.element=quadratic"});
  CHECK(given.body->element == Element::quadratic);
  CHECK(given.source.accuracy->taken.fine == 700);
  CHECK(given.identity != first.identity);
  // what cannot be met is said
  const Scene never = load(shop, ball, {"body.fine=false", "body.element=linear", "body.accuracy=0.0001"});
  CHECK_FALSE(never.source.accuracy->reached);
  REQUIRE_FALSE(never.source.warnings.empty());
  CHECK_THAT(never.source.warnings.back(), Contains("body.accuracy", "0.01 % wanted"));
}

TEST_CASE("of a volume mesh body.accuracy chooses the fine body alone",
          "[scene]" SLOW("makes and solves fine bodies")) {
  const Workshop shop;
  write_mesh(shop.path() / "ball.msh", phantom("ball", 300));
  const Scene scene =
      load(shop, "mesh = \"ball.msh\"\naccuracy = 0.2\n", {"contact.nearest=[0.0, 0.0, 1.0]"});
  CHECK(scene.body->element == Element::linear);
  CHECK(scene.body->mesh.tets.size() == phantom("ball", 300).tets.size());
  CHECK(scene.source.accuracy->taken.fine > 0);
  CHECK_THAT(error_of([&] {
               load(shop, "mesh = \"ball.msh\"\naccuracy = 0.2\nfine = { elements = 500 }\n",
                    {"contact.nearest=[0.0, 0.0, 1.0]"});
             }),
             Contains("scene.toml:3: body.accuracy", "no body.fine beside it"));
  CHECK_THAT(error_of([&] { load(shop, "phantom = \"ball\"\naccuracy = 0\n"); }),
             Contains("body.accuracy", "above 0"));
}
