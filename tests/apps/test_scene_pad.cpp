// [contact] with a pad and body.fine: values, defaults, refusals, identity, the cached rest jets.

#include "apps/scene/scene.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/phantom.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/body/pad.hpp"
#include "tests/support/executable.hpp"

namespace {

const std::string pad = "[contact]\npad = 900.0\n";
const std::string fine = "body.fine={elements=500}";
constexpr const char* cube_off =
    "OFF\n8 12 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 "
    "6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n";

Scene load(const Workshop& shop, const std::string& text, const std::vector<std::string>& overrides = {}) {
  return load_scene(shop.write("scene.toml", text), overrides, nullptr, {.quiet = true});
}

std::string refusal(const Workshop& shop, const std::string& text,
                    const std::vector<std::string>& overrides = {}) {
  return error_of([&] { load(shop, text, overrides); });
}

// A scene of a mesh file: sections of the body, lines that all have, then `more`.
std::string file_scene(const std::string& body, const std::string& more) {
  return "[body]\n" + body +
         "[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\npoisson = 0.3\n"
         "[state_space]\nspacing = 0.004\nbox = [[0, 0, 0], [0.004, 0, 0]]\n" +
         more;
}

}  // namespace

TEST_CASE("a pad has the place, radius and stiffness that the scene gives", "[scene]") {
  const Workshop shop;
  const std::string at = "nearest = [0.071, 0.011, 0.03]\nradius = 0.008\n";
  const Scene scene = load(shop, beam_scene(pad + at));
  REQUIRE(scene.body->pad);
  CHECK(scene.body->contact.empty());
  CHECK((scene.body->pad->site - Vec3(0.071, 0.011, 0.02)).norm() < 1e-12);  // onto the upper side
  CHECK(scene.body->pad->radius == 0.008);
  CHECK(scene.body->pad->stiffness == 900);
  CHECK((scene.inward - -Vec3::UnitZ()).norm() < 1e-12);
}

TEST_CASE("a pad on a phantom is at its tip, also of a scaled one, and about a fingertip wide", "[scene]") {
  const Workshop shop;
  for (const std::string name : {"beam", "liver"})
    for (const double length : {0.0, 0.3}) {
      const std::string text = "[body]\nphantom = \"" + name + "\"\nelements = 400\n" +
                               (length > 0 ? "length = 0.3\n" : "") +
                               "[material]\nlaw = \"linear\"\nyoung = 5000.0\npoisson = 0.3\n" + pad +
                               "[state_space]\nspacing = 0.004\n";
      const Scene scene = load(shop, text);
      REQUIRE(scene.body->pad);
      const Box box = bounding_box(phantom_surface(name));
      const double scale = length > 0 ? length / box.size().maxCoeff() : 1;
      CHECK((scene.body->pad->site - scale * phantom_tip(name)).norm() <
            0.01 * longest_side(scene.body->mesh));
      CHECK((nearest_site(scene.body->mesh, scene.body->pad->site) - scene.body->pad->site).norm() < 1e-12);
      CHECK(scene.body->pad->radius == 0.02);
      CHECK(scene.body->pad->stiffness == 900);
    }
  CHECK_FALSE(load(shop, beam_scene()).body->pad);  // rigid without the key
  CHECK_FALSE(load(shop, beam_scene("[contact]\nnearest = [0.1, 0, 0]\nradius = 0.01\n")).body->pad);
}

TEST_CASE("pads and fine bodies that cannot be are refused with file, line and key", "[scene]") {
  const Workshop shop;
  CHECK_THAT(refusal(shop, beam_scene(pad + "group = \"contact\"\n")),
             Contains("scene.toml:13: contact.group", "no nodes beside pad"));
  CHECK_THAT(refusal(shop, beam_scene(pad + "node = 3\n")), Contains("scene.toml:13: contact.node"));
  CHECK_THAT(refusal(shop, beam_scene(pad + "nodes = [3]\n")), Contains("scene.toml:13: contact.nodes"));
  CHECK_THAT(refusal(shop, beam_scene("[contact]\npad = 0\n")),
             Contains("scene.toml:12: contact.pad", "above 0"));
  CHECK_THAT(refusal(shop, beam_scene(pad + "radius = -0.01\n")), Contains("scene.toml:13: contact.radius"));
  CHECK_THAT(refusal(shop, beam_scene(pad + "nearest = [71, 10, 20]\n")),
             Contains("scene.toml:13: contact.nearest", "far from the body"));
  CHECK_THAT(refusal(shop, beam_scene(), {"contact.pad=soft"}), Contains("--set contact.pad"));
  CHECK_THAT(refusal(shop, beam_scene(pad), {"body.fine=true"}),
             Contains("--set body.fine", "false or a table { elements = N }"));
  CHECK_THAT(refusal(shop, beam_scene(pad), {"body.fine={elments=500}"}),
             Contains("did you mean 'body.fine.elements'"));
  CHECK_THAT(refusal(shop, beam_scene(pad), {"body.fine={elements=20}"}),
             Contains("--set body.fine: 20 graded elements cannot be met"));
  CHECK_THAT(refusal(shop, beam_scene(pad), {"body.fine={elements=500, element=\"cubic\"}"}),
             Contains("body.fine.element", "quadratic"));
  CHECK_THAT(refusal(shop, beam_scene(pad), {"body.fine={elements=3}"}), Contains("body.fine.elements"));

  write_msh(shop.path() / "beam.msh", phantom("beam", 240));
  const std::string mesh = "mesh = \"beam.msh\"\n", clamp = "[clamp]\ngroup = \"clamp\"\n";
  CHECK_THAT(refusal(shop, file_scene(mesh, clamp + pad)),
             Contains("contact.nearest: missing, expected [x, y, z]"));
  CHECK_THAT(refusal(shop, file_scene(mesh, clamp + pad + "nearest = [0.0, 0.01, 0.01]\nradius = 0.002\n")),
             Contains("all nodes under the pad are clamped"));

  shop.write("cube.off", cube_off);
  const std::string cube = "mesh = \"cube.off\"\nelements = 300\nlength = 0.1\n",
                    below = "[clamp]\nbelow = { axis = \"z\", share = 0.1 }\n";
  const auto numbered = [&](const std::string& sets) {
    return refusal(shop, file_scene(cube, sets), {"body.fine={elements=600}"});
  };
  CHECK_THAT(numbered("[clamp]\nnodes = [0, 1, 2, 3]\n" + pad + "nearest = [0.05, 0.05, 0.1]\n"),
             Contains("clamp.nodes: numbers nodes of one mesh", "body.fine = false"));
  CHECK_THAT(numbered(below + "[contact]\nnode = 7\n"), Contains("contact.node: numbers nodes"));
  CHECK_THAT(numbered(below + "[contact]\nnodes = [6, 7]\n"), Contains("contact.nodes: numbers nodes"));
}

TEST_CASE("body.fine corrects phantoms, surfaces and volume meshes", "[scene]") {
  const Workshop shop;
  const auto words = [](const Scene& scene) {
    REQUIRE(scene.body->fine);
    CHECK(scene.body->fine->stiffness().norm() > 0);
    CHECK(scene.body->fine->radius() > 0);
    return scene.body->fine->fine_body();
  };
  CHECK_FALSE(load(shop, beam_scene(pad)).body->fine);
  CHECK_FALSE(load(shop, beam_scene(pad), {"body.fine=false"}).body->fine);
  CHECK_THAT(words(load(shop, beam_scene(pad), {fine})), Contains("quadratic elements, "));
  CHECK_THAT(words(load(shop, beam_scene(pad), {"body.fine={elements=900, element=\"linear\"}"})),
             Contains("linear elements, "));
  CHECK_THAT(words(load(shop, beam_scene(), {fine})), Contains("quadratic elements, "));  // a rigid patch

  const TetMesh beam = phantom("beam", 240);
  write_msh(shop.path() / "beam.msh", beam);
  const std::string sets = "[clamp]\ngroup = \"clamp\"\n" + pad + "nearest = [0.08, 0.01, 0.02]\n";
  for (const auto& [wanted, level] : {std::pair(500, 1), std::pair(1000, 8), std::pair(5000, 8)})
    CHECK_THAT(words(load(shop, file_scene("mesh = \"beam.msh\"\n", sets),
                          {"body.fine={elements=" + std::to_string(wanted) + "}"})),
               Contains("quadratic elements, " + std::to_string(level * static_cast<int>(beam.tets.size())) +
                        " tetrahedra"));

  shop.write("cube.off", cube_off);
  const std::string cube = "mesh = \"cube.off\"\nelements = 300\nlength = 0.1\n",
                    on_top = "[clamp]\nbelow = { axis = \"z\", share = 0.2 }\n" + pad +
                             "nearest = [0.05, 0.05, 0.1]\n";
  CHECK_THAT(words(load(shop, file_scene(cube, on_top), {"body.fine={elements=900}"})),
             Contains("quadratic elements, "));
}

TEST_CASE("identity tells pads and fine bodies apart", "[scene]") {
  const Workshop shop;
  const auto identity = [&](const std::string& more, const std::vector<std::string>& overrides = {}) {
    return load(shop, beam_scene(more), overrides).identity;
  };
  const std::string uniform = "body.uniform=true";  // else a pad's mesh is another one
  const BodyIdentity rigid = identity("", {uniform}), padded = identity(pad, {uniform});
  const auto only = [](const BodyIdentity& a, const BodyIdentity& b, const std::string& key) {
    for (const auto& [name, value] : a) {
      INFO(name);
      CHECK((b.contains(name) && b.at(name) == value) == (name != key));
    }
  };
  only(rigid, padded, "contact");
  for (const char* override : {"contact.pad=901", "contact.radius=0.019", "contact.nearest=[0.1,0.011,0.01]"})
    only(padded, identity(pad, {uniform, override}), "contact");
  CHECK(identity(pad, {uniform, "contact.radius=0.02"}) == padded);

  CHECK_FALSE(padded.contains("fine"));
  const BodyIdentity corrected = identity(pad, {uniform, fine});
  REQUIRE(corrected.contains("fine"));
  only(corrected, padded, "fine");
  CHECK(identity(pad, {uniform, fine}) == corrected);
  for (const char* override : {"body.fine.elements=900", "body.fine.element=linear"})
    only(corrected, identity(pad, {uniform, fine, override}), "fine");
}

TEST_CASE("rest jets are kept: used again, and damaged ones are made anew", "[scene]") {
  const BeamShop shop(pad);
  const std::string solve = "solve beam.toml --at=0,0.001,-0.003 --json --quiet --set '" + fine + "'";
  const auto force = [&] { return shop.forefeel(solve).json()["states"][0]["force"]; };
  const auto of_jets = [&](const std::string& command) {
    return shop.shell("cd ../cache/forefeel && " + command + " *.jet.json").out;
  };
  const auto first = force();
  // The time that a jet took is not the same twice.
  const std::string cat = "sed -E '/\"(seconds|sha256)\"/d'", content = of_jets(cat),
                    files = of_jets("stat -c '%n %i %y'");
  CHECK(std::ranges::count(files, '\n') >= 2);  // the fine body's and the body's own
  CHECK_THAT(of_jets("cat"), Contains("\"stiffness\"", "\"e005\"", "\"sha256\""));
  CHECK(force() == first);
  CHECK(of_jets("stat -c '%n %i %y'") == files);  // read, not written again

  // a wrong number with an unchanged sum, half a file, no file at all
  for (const char* damage :
       {"sed -i 's/\"e300\": /\"e300\": 1/'", "truncate -s 200", "truncate -s 0", "rm"}) {
    CAPTURE(damage);
    of_jets(damage);
    CHECK(of_jets(cat) != content);
    CHECK(force() == first);
    CHECK(of_jets(cat) == content);
  }
  CHECK(shop.json("solve beam.toml --at=0,0.001,-0.003 --quiet")["states"][0]["force"] != first);
}

TEST_CASE("info and a session's summary say the same of the contact", "[scene]") {
  const Workshop shop;
  for (const bool padded : {true, false}) {
    shop.write("beam.toml", beam_scene(padded ? pad : ""));
    const auto info = shop.json("info beam.toml --quiet");
    shop.forefeel(
        "session beam.toml --clock virtual --seconds 0.1 --device path:press,speed=0.02 --quiet -o run");
    const auto summary = json::parse(shop.read("run/summary.json"));
    CHECK(summary["contact"] == info["contact"]);
    CHECK(summary["contact"]["kind"] == (padded ? "pad" : "rigid"));
    CHECK(summary["contact"]["area"].get<double>() > 0);
    for (const char* key : {"radius", "pad", "stiffness", "clamped_share"})
      CHECK(summary["contact"][key].is_number() == padded);
    CHECK(summary["contact"]["pulling_share"].is_array() == padded);
    fs::remove_all(shop.path() / "run");
  }
}
