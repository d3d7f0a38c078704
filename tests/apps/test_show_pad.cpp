// forefeel show of a body under a pad: its springs as colour on the surface.

#include "geometry/common/types.hpp"
#include "tests/apps/shown_page.hpp"
#include "tests/apps/vtk_files.hpp"

namespace {

constexpr double radius = 0.008, springs = 700, peak = 3 * springs / (std::numbers::pi * radius * radius);

// The beam of beam_scene() with a pad at a place of its upper side, z = 0.02, and near its edge at y = 0.
void write_scene(const Workshop& shop, const std::string& name, double y) {
  shop.write(name, beam_scene("[contact]\npad = 700.0\nradius = 0.008\nnearest = [0.071, " +
                              std::to_string(y) + ", 0.02]\n"));
}

struct Shown {
  std::vector<Vec3> place;  // of the pad's points, from its site [m]
  std::vector<float> weight;
  std::vector<std::uint32_t> triangles;
};

// The pad of a page's body.
Shown pad_of(const json& body) {
  const auto nodes = floats(body["nodes"]), at = floats(body["pad"]["at"]);
  const auto corners = numbers<std::uint32_t>(body["triangles"], "u32");
  Shown shown;
  shown.weight = floats(body["pad"]["weight"]);
  shown.triangles = numbers<std::uint32_t>(body["pad"]["triangles"], "u32");
  for (const std::uint32_t facet : numbers<std::uint32_t>(body["pad"]["facet"], "u32")) {
    Vec3 place = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      for (int axis = 0; axis < 3; ++axis)
        place[axis] += double(at[3 * shown.place.size() + i]) *
                       double(nodes[3 * corners[3 * facet + i] + std::size_t(axis)]);
    shown.place.push_back(place);
  }
  return shown;
}

// True where pages can be made here.
bool made(const Workshop& shop, const std::string& scene, const std::string& page, json& report) {
  const auto outcome = shop.forefeel("show " + scene + " -o " + page + " --json");
  if (outcome.code == 2 && outcome.err.find("three.js") != std::string::npos) {
    skip("three.js was not found at build time and is not installed");
    return false;
  }
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  report = outcome.json();
  return true;
}

}  // namespace

TEST_CASE("the page shows a pad's springs as shares of their peak over the surface", "[show]") {
  const Workshop shop;
  write_scene(shop, "pad.toml", 0.011);
  json report;
  if (!made(shop, "pad.toml", "pad.html", report)) return;
  CHECK(report["body"]["contact"] == 0);
  CHECK(report["body"]["pad"] == Approx(peak));
  const ShownPage page(shop.path() / "pad.html");
  CHECK(page.data["body"]["pad"]["peak"] == Approx(peak));
  const Shown pad = pad_of(page.data["body"]);
  REQUIRE(pad.weight.size() == pad.place.size());
  double reach = 0, sum = 0;
  for (std::size_t i = 0; i < pad.place.size(); ++i) {
    CHECK(std::abs(pad.place[i].z()) < 1e-7);  // the upper side
    const double fall = std::max(0.0, 1 - pad.place[i].squaredNorm() / (radius * radius));
    CHECK(pad.weight[i] == Approx(fall * fall).margin(1e-5));
    if (pad.weight[i] > 0) reach = std::max(reach, pad.place[i].norm());
  }
  CHECK(reach > 0.9 * radius);
  CHECK(*std::ranges::max_element(pad.weight) > 0.95);
  for (std::size_t t = 0; t < pad.triangles.size(); t += 3) {
    std::array<Vec3, 3> p;
    double weight = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = pad.place.at(pad.triangles[t + i]);
      weight += double(pad.weight[pad.triangles[t + i]]) / 3;
    }
    const Vec3 area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]);
    CHECK(area.z() > 0);  // outward
    sum += weight * peak * area.norm();
  }
  CHECK(sum == Approx(springs).epsilon(0.02));  // on a flat surface the springs sum to the pad's stiffness

  shop.write("beam.toml", beam_scene());
  REQUIRE(made(shop, "beam.toml", "beam.html", report));
  CHECK(report["body"]["pad"].is_null());
  CHECK(ShownPage(shop.path() / "beam.html").data["body"]["pad"].is_null());
}

TEST_CASE("across an edge the springs shown fall with the angle to the mean normal", "[show]") {
  const Workshop shop;
  write_scene(shop, "edge.toml", 0.002);
  json report;
  if (!made(shop, "edge.toml", "edge.html", report)) return;
  const Shown pad = pad_of(ShownPage(shop.path() / "edge.html").data["body"]);
  const double r2 = radius * radius;
  // int (1 - |y - s|^2 / r^2)^2 over the upper side (u >= -2 mm beside the site) and the side below its edge
  double upper = 0, side = 0;
  constexpr int n = 800;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double u = radius * (2 * (i + 0.5) / n - 1), v = radius * (2 * (j + 0.5) / n - 1);
      const auto fall = [&](double square) { return std::pow(std::max(0.0, 1 - square / r2), 2); };
      if (u > -0.002) upper += fall(u * u + v * v);
      if (u > 0) side += fall(0.002 * 0.002 + u * u + v * v);
    }
  const auto turned = [&](double cosine) {
    const double tau = std::clamp(2 * cosine, 0.0, 1.0);
    return 3 * tau * tau - 2 * tau * tau * tau;
  };
  const double length = std::hypot(upper, side);
  std::size_t on_side = 0;
  for (std::size_t i = 0; i < pad.place.size(); ++i) {
    const Vec3& y = pad.place[i];
    const bool edge = std::abs(y.z()) < 1e-6 && std::abs(y.y() + 0.002) < 1e-6;
    if (edge) continue;  // both facets have it
    on_side += y.z() < -1e-6;
    const double fall = std::max(0.0, 1 - y.squaredNorm() / r2);
    CHECK(pad.weight[i] ==
          Approx(fall * fall * turned((y.z() < -1e-6 ? side : upper) / length)).margin(2e-4));
  }
  CHECK(on_side > 20);
}

TEST_CASE("in the page's scene the pad has its colours and follows the surface",
          "[show]" SLOW("runs node, which only run.sh all installs")) {
  const Workshop shop;
  write_scene(shop, "pad.toml", 0.011);
  json report;
  if (!made(shop, "pad.toml", "pad.html", report)) return;
  if (!has_command("node")) return skip("node is not installed");
  const ShownPage page(shop.path() / "pad.html");
  shop.write("data.json", page.data.dump());
  shop.write("three.js", page.scripts[0]);
  const std::string& own = page.scripts[2];
  shop.write("scene.js",
             "const fs = require('fs');\n"
             "globalThis.THREE = require('./three.js');\n"
             "globalThis.window = {devicePixelRatio: 1};\n"
             "const pen = new Proxy({}, {get: () => () => {}, set: () => true});\n"
             "globalThis.document = {createElement: () => ({getContext: () => pen}),\n"
             "  getElementById: () => ({textContent: fs.readFileSync('data.json', 'utf8')})};\n" +
                 own.substr(0, own.find("const byId")) +
                 "makeBody();\n"
                 "const {position, color} = layers.contact.geometry.attributes;\n"
                 "const rest = [...position.array];\n"
                 "moveBody(scene.body.nodes.map((v, i) => 0.1 * v + i % 3));\n"
                 "console.log(JSON.stringify({rest, moved: [...position.array], colour: [...color.array],\n"
                 "  weight: [...scene.body.pad.weight], body: rgb('body'), contact: rgb('contact')}));\n");
  const auto outcome = shop.shell("node scene.js");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const json found = outcome.json();
  const Shown pad = pad_of(page.data["body"]);
  REQUIRE(found["weight"].size() == pad.weight.size());
  for (std::size_t i = 0; i < pad.weight.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double rest = found["rest"][3 * i + k];  // [mm]
      CHECK(rest == Approx(1e3 * pad.place[i][static_cast<int>(k)]).margin(1e-4));
      CHECK(found["moved"][3 * i + k] == Approx(1.1 * rest + double(k)).margin(1e-4));
      const double body = found["body"][k], contact = found["contact"][k];
      CHECK(found["colour"][3 * i + k] ==
            Approx(body + double(pad.weight[i]) * (contact - body)).margin(1e-5));
    }
}

TEST_CASE("the .vtu of a body under a pad show its springs",
          "[show]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  write_scene(shop, "pad.toml", 0.011);
  shop.run("show pad.toml -o pad.vtu");
  const json seen = read_by_vtk(shop, "pad.vtu");
  if (seen.is_null()) return;
  CHECK(seen[0]["point_data"]["pad"]["min"] == 0);
  const double most = seen[0]["point_data"]["pad"]["max"];
  CHECK(most > 0.3 * peak);
  CHECK(most <= Approx(peak));
}

TEST_CASE("a scene with contact.anywhere is coloured by its stiffness at rest", "[show]") {
  const Workshop shop;
  shop.write("any.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"linear\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n");
  json report;
  if (!made(shop, "any.toml", "any.html", report)) return;
  const json info = shop.json("info any.toml");
  CHECK(report["box"].is_null());
  CHECK(report["body"]["pad"].is_null());
  CHECK(report["body"]["stiffness"][0] == Approx(info["field"]["body_stiffness"][0].get<double>()));
  CHECK(report["body"]["stiffness"][1] == Approx(info["field"]["body_stiffness"][2].get<double>()));
  const json body = ShownPage(shop.path() / "any.html").data["body"];
  CHECK(body["pad"]["shade"] == "stiffness");
  const Shown shown = pad_of(body);
  REQUIRE(shown.weight.size() == shown.place.size());
  double near = 0, far = 1;
  for (std::size_t i = 0; i < shown.place.size(); ++i) {
    CHECK(shown.weight[i] >= 0);
    CHECK(shown.weight[i] <= 1);
    if (shown.place[i].x() < 0.02) near = std::max(near, double(shown.weight[i]));
    if (shown.place[i].x() > 0.08) far = std::min(far, double(shown.weight[i]));
  }
  CHECK(near == 1);  // beside the clamp
  CHECK(far < 0.05);
  shop.run("show any.toml -o any.vtu");
  CHECK_THAT(shop.read("any.vtu"), Contains("Name=\"stiffness\""));
  // A linear body is known everywhere.
  const auto trusted = shop.run("show any.toml --trust 0.01 -o trust.vtu --json");
  CHECK(trusted.json()["body"]["untrusted"] == 0);
  CHECK(trusted.json()["body"]["stiffness"].is_null());
  CHECK_THAT(shop.read("trust.vtu"), Contains("Name=\"error\""));
  shop.write("deep.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\n"
             "young = 5000.0\npoisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n");
  CHECK(shop.json("show deep.toml --trust 0.03 -o deep.vtu")["body"]["untrusted"].get<double>() > 0.5);
  check_refused(shop, "show any.toml --trust 5 -o no.vtu", {"--trust", "metres"});
}
