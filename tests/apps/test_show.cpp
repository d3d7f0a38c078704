// forefeel show: the content of the page, of the still pictures and of the files for ParaView; bad input.

#include "geometry/coverage/setups.hpp"
#include "tests/apps/shown_page.hpp"
#include "tests/apps/vtk_files.hpp"

namespace {

// A CSV with a header as rows of words by column.
std::vector<std::map<std::string, std::string>> table(const fs::path& file) {
  std::istringstream in(text_of(file));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> words;
    std::istringstream rest(line + ",");
    for (std::string word; std::getline(rest, word, ',');) words.push_back(word);
    return words;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> columns = cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> words = cells(line);
    rows.emplace_back();
    for (std::size_t i = 0; i < std::min(words.size(), columns.size()); ++i)
      rows.back()[columns[i]] = words[i];
  }
  return rows;
}

// A slab with a gap, small enough to be quick: gap.csv.
void write_gap(const Workshop& shop) {
  std::ostringstream text;
  text.precision(17);
  text << "x,y,z,fx,fy,fz\n";
  for (const forefeel::Vec3& p : forefeel::make_setup("gap", {.depth = 3, .half_width = 4}).states)
    text << p.x() << ',' << p.y() << ',' << p.z() << ",0,0,1\n";
  shop.write("gap.csv", text.str());
}

// True where pages can be made here: three.js is built in or installed. Makes try.html of gap.csv.
bool has_three(const Workshop& shop) {
  write_gap(shop);
  if (shop.forefeel("show gap.csv -o try.html --quiet").code == 0) return true;
  skip("three.js was not found at build time and is not installed");
  return false;
}

}  // namespace

TEST_CASE("the page of a scene needs no other file, and holds body, clamp, contact and box", "[show]") {
  const Workshop shop;
  if (!has_three(shop)) return;
  shop.write("beam.toml", beam_scene());
  const auto made = shop.run("show beam.toml -o beam.html --json");
  const json report = made.json();
  CHECK(report["kind"] == "scene");
  CHECK(report["files"] == json({"beam.html"}));
  CHECK(report["size_bytes"] == fs::file_size(shop.path() / "beam.html"));
  const ShownPage page(shop.path() / "beam.html");
  CHECK_THAT(page.text, Contains("default-src 'none'"));  // the browser loads nothing
  for (const char* word : {" src=", " href=", "@import", "url("})
    CHECK_THAT(page.text.substr(0, page.text.find("<script>")), !Contains(word));
  REQUIRE(page.scripts.size() == 3);
  for (const char* word : {"http:", "https:", "fetch(", "XMLHttpRequest", "import "})
    CHECK_THAT(page.scripts[2], !Contains(word));
  const json& body = page.data["body"];
  const auto nodes = floats(body["nodes"]);
  const auto corners = numbers<std::uint32_t>(body["triangles"], "u32");
  const auto role = numbers<std::uint8_t>(body["role"], "u8");
  CHECK(nodes.size() == 3 * report["body"]["nodes"].get<std::size_t>());
  CHECK(corners.size() == 3 * report["body"]["triangles"].get<std::size_t>());
  // A closed surface: V - E + F = 2 with 3 F = 2 E.
  CHECK(2 * (nodes.size() / 3) == corners.size() / 3 + 4);
  CHECK(*std::max_element(corners.begin(), corners.end()) + 1 == nodes.size() / 3);
  CHECK(std::count(role.begin(), role.end(), 1) == report["body"]["clamp"]);
  CHECK(std::count(role.begin(), role.end(), 2) == report["body"]["contact"]);
  CHECK(report["body"]["contact"] > 0);
  CHECK(page.data["box"]["high"] == json({0.004, 0.004, 0.004}));
  CHECK(page.data["spacing"] == 0.004);
  CHECK(page.data["states"].is_null());
  // The contact is where positions count from.
  double middle = 0, n = 0;
  for (std::size_t i = 0; i < role.size(); ++i)
    if (role[i] == 2) middle += nodes[3 * i], ++n;
  CHECK(middle / n == Approx(0).margin(1e-6));
}

TEST_CASE("node reads the page's scripts, and they unpack the data",
          "[show]" SLOW("runs node, which only run.sh all installs")) {
  const Workshop shop;
  if (!has_three(shop)) return;
  if (!has_command("node")) return skip("node is not installed");
  const ShownPage page(shop.path() / "try.html");
  for (const std::string& script : page.scripts) {
    shop.write("script.js", script);
    const auto checked = shop.shell("node --check script.js");
    INFO(checked.err);
    CHECK(checked.code == 0);
  }
  const std::string& own = page.scripts[2];
  shop.write("data.json", page.data.dump());
  shop.write(
      "unpack.js",
      "const fs = require('fs');\n"
      "globalThis.document = {getElementById: () => ({textContent: fs.readFileSync('data.json', "
      "'utf8')})};\n" +
          own.substr(0, own.find("const size =")) +
          "console.log(JSON.stringify({states: scene.states.label.length, moments: scene.labels.length, "
          "cells: scene.labels[0].label.length, high: scene.box.high[0]}));\n");
  const auto outcome = shop.shell("node unpack.js");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  CHECK(outcome.json()["states"] == floats(page.data["states"]["at"]).size() / 3);
  CHECK(outcome.json()["moments"] == 1);
  CHECK(outcome.json()["cells"] == labels(page.data["states"]["labels"][0]).size());
  CHECK(outcome.json()["high"] == Approx(1e3 * page.data["box"]["high"][0].get<double>()));
}

TEST_CASE("the labels of the cut planes are those that classify gives at the cells' centres",
          "[show]" SLOW("labels tens of thousands of cells twice")) {
  const Workshop shop;
  if (!has_three(shop)) return;
  const ShownPage page(shop.path() / "try.html");
  const json& grid = page.data["states"]["labels"][0];
  const std::vector<int> all = labels(grid);
  const std::size_t nx = grid["count"][0], ny = grid["count"][1], nz = grid["count"][2];
  REQUIRE(all.size() == nx * ny * nz);
  const json low = page.data["box"]["low"], high = page.data["box"]["high"];
  std::ostringstream points;
  points.precision(17);
  points << "x,y,z\n";
  std::vector<int> expected;
  for (std::size_t cell = 0; cell < all.size(); cell += 101) {
    const std::size_t at[3] = {cell % nx, cell / nx % ny, cell / nx / ny}, n[3] = {nx, ny, nz};
    for (std::size_t a = 0; a < 3; ++a) {
      const double l = low[a], h = high[a];
      points << l + (h - l) * (double(at[a]) + 0.5) / double(n[a]) << (a < 2 ? ',' : '\n');
    }
    expected.push_back(all[cell]);
  }
  shop.write("centres.csv", points.str());
  const json classified = shop.json("classify gap.csv --points centres.csv");
  REQUIRE(classified["labels"].size() == expected.size());
  const std::vector<std::string> names{"safe", "sparse", "gap", "blank"};
  std::size_t different = 0, kinds = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    different += classified["labels"][i] != names[static_cast<std::size_t>(expected[i])];
  CHECK(different == 0);
  for (int k = 0; k < 3; ++k) kinds += std::count(expected.begin(), expected.end(), k) > 0;
  CHECK(kinds == 3);
  CHECK(page.data["states"]["volume"][0] == Approx(classified["volume"]["safe"].get<double>()));
}

TEST_CASE("the page of a run holds its path, when states became known, and shapes that follow the hand",
          "[show]") {
  const Workshop shop;
  if (!has_three(shop)) return;
  shop.write("beam.toml", beam_scene("displacements = true\n"));
  const auto session = shop.run(
      "session beam.toml --clock virtual --seconds 1 --device path:circle,amplitude=0.003,speed=0.02 --cost "
      "constant:0.02 -o run");
  CHECK_THAT(session.out, Contains("look at it: forefeel show run -o run/show.html\n"));
  const auto made = shop.run("show run -o run/show.html --json");
  CHECK_THAT(made.err, !Contains("warning"));
  const json report = made.json();
  const auto frames = table(shop.path() / "run/frames.csv");
  CHECK(report["frames"] == frames.size());
  const ShownPage page(shop.path() / "run/show.html");
  const auto t = floats(page.data["run"]["t"]), at = floats(page.data["run"]["at"]);
  REQUIRE(t.size() == frames.size());  // few enough to be shown all
  for (std::size_t i = 0; i < frames.size(); i += 37) {
    CHECK(t[i] == Approx(std::stod(frames[i].at("t"))));
    CHECK(at[3 * i] == Approx(std::stod(frames[i].at("x"))).margin(1e-9));
  }
  // When each state became known.
  const auto place = floats(page.data["states"]["at"]), known = floats(page.data["states"]["known"]);
  std::size_t found = 0;
  for (const auto& row : table(shop.path() / "run/dispatch.csv"))
    for (std::size_t i = 0; i < known.size(); ++i)
      if (row.at("status") == "solved" && std::abs(place[3 * i] - std::stod(row.at("x"))) < 1e-8 &&
          std::abs(place[3 * i + 1] - std::stod(row.at("y"))) < 1e-8 &&
          std::abs(place[3 * i + 2] - std::stod(row.at("z"))) < 1e-8) {
        CHECK(known[i] == Approx(std::stod(row.at("known"))));
        ++found;
      }
  CHECK(found > 5);
  const json& grids = page.data["states"]["labels"];
  REQUIRE(grids.size() == 12);
  const auto first = labels(grids.front()), last = labels(grids.back());
  CHECK(std::count(last.begin(), last.end(), 0) > std::count(first.begin(), first.end(), 0));

  // The contact moves with the hand; the clamp stays.
  const json& shapes = page.data["run"]["shapes"];
  REQUIRE(report["shapes"].get<std::size_t>() > 50);
  const auto when = floats(shapes["t"]);
  const auto moved = numbers<std::int16_t>(shapes["moved"], "i16");
  const auto role = numbers<std::uint8_t>(page.data["body"]["role"], "u8");
  REQUIRE(moved.size() == 3 * role.size() * when.size());
  const double scale = shapes["scale"];
  for (std::size_t k = when.size() / 2; k < when.size(); k += 20) {
    const std::size_t frame =
        static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), when[k] - 1e-6f) - t.begin());
    for (std::size_t i = 0; i < role.size(); ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        const double here = scale * moved[3 * (k * role.size() + i) + a];
        if (role[i] == 1 && std::abs(here) > 1e-9) FAIL("a clamped node moves");
        if (role[i] == 2 && std::abs(here - at[3 * frame + a]) > 2e-4) FAIL("the contact is not at the hand");
      }
  }
}

TEST_CASE("the .vtu of show holds the body with clamp and contact, and labels, states and path beside it",
          "[show]" SLOW("compares with VTK, which only run.sh all installs")) {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --seconds 0.3 --cost constant:0.02 --quiet -o run");
  const json report = shop.json("show run -o look.vtu");
  CHECK(report["files"] == json({"look.vtu", "look_labels.vtu", "look_states.vtu", "look_path.vtu"}));
  const json seen = read_by_vtk(shop, "look.vtu look_labels.vtu look_states.vtu look_path.vtu");
  if (seen.is_null()) return;
  CHECK(seen[0]["types"] == json({10}));
  CHECK(seen[0]["cells"] == report["body"]["elements"]);
  CHECK(seen[0]["point_data"]["role"]["max"] == 2);
  CHECK(seen[1]["types"] == json({11}));
  CHECK(seen[2]["points"] == report["states"]);
  CHECK(seen[3]["points"] == report["frames_shown"]);
  CHECK(seen[3]["point_data"]["time"]["max"] == Approx(0.3).margin(0.01));
}

TEST_CASE("generate and mesh name the command that shows what they made, and it works as printed", "[show]") {
  const Workshop shop;
  if (!has_three(shop)) return;
  shop.write("my beam.toml", beam_scene());
  for (const std::string command :
       {"generate 'my beam.toml' --set material.young=4000.0 -o 'my states.states'",
        "mesh --phantom ball --elements 300 -o ball.msh"}) {
    const auto outcome = shop.run(command);
    const std::string lead = "look at it: forefeel ";
    const std::size_t at = outcome.out.find(lead);
    REQUIRE(at != std::string::npos);
    const std::string line = outcome.out.substr(at + lead.size());
    const auto shown = shop.run(line.substr(0, line.find('\n')) + " --json");
    CHECK(shown.json()["body"]["elements"] > 100);
  }
  // The state file names its scene.
  shop.run("generate 'my beam.toml' -o own.states --quiet");
  const json own = shop.json("show own.states -o own.vtu");
  CHECK(own["states"] == 27);
  CHECK(own["body"]["contact"] > 0);
}

TEST_CASE("what cannot be shown is refused in one line", "[show]") {
  const BeamShop shop;
  shop.write("other.toml", beam_scene("[clamp]\nbelow = { axis = \"x\", share = 0.4 }\n"));
  shop.write("words.txt", "hello\n");
  fs::create_directories(shop.path() / "broken");
  shop.write("broken/frames.csv", "t,x,y,z\n1,2\n");
  shop.run("generate beam.toml -o s.states --quiet");
  shop.run("mesh --phantom ball --elements 300 -o ball.msh --quiet");
  check_refused(shop, "show beam.toml -o beam.pdf", {"beam.pdf", ".html or .vtu"});
  check_refused(shop, "show nothing.states -o out.html", {"nothing.states"});
  check_refused(shop, "show words.txt -o out.vtu", {"words.txt", "expected a scene"});
  check_refused(shop, "show . -o out.vtu", {"frames.csv"});
  check_refused(shop, "show broken -o out.vtu", {"frames.csv:2"});
  check_refused(shop, "show s.states --scene other.toml -o out.vtu", {"another body", "clamp", "--foreign"});
  check_refused(shop, "show ball.msh --scene beam.toml -o out.vtu", {"--scene"});
  check_refused(shop, "show ball.msh --set model.neighbours=5 -o out.vtu", {"--set"});
  check_refused(shop, "show ball.msh --foreign -o out.vtu", {"--foreign"});
  check_refused(shop, "show s.states -o no/such/folder/out.vtu", {"no/such/folder"});
  check_refused(shop, "show beam.toml", {"-o is missing, expected OUT.html or OUT.vtu"});
  shop.run("show s.states --scene other.toml --foreign -o out.vtu");
}
