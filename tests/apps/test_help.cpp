// The reference of `forefeel help` lists exactly what the readers accept and the writers write.

#include "apps/main/help_topics.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_table.hpp"
#include "apps/scene/spec_text.hpp"
#include "apps/study/study_file.hpp"
#include "tests/apps/study_fixture.hpp"
#include "tests/support/executable.hpp"

namespace {

const DeclaredTable& scene_table(const std::string& name) {
  return *std::ranges::find(scene_tables(), name, &DeclaredTable::name);
}

std::string default_of(const std::string& table, const std::string& key) {
  const std::vector<Declared>& rows = scene_table(table).rows;
  return std::ranges::find(rows, key, &Declared::name)->standard;
}

// A value that a setting of a device takes.
std::string value_for(const std::string& setting) {
  if (setting == "target") return "circle";
  if (setting == "offset" || setting == "register") return "0/0/0.001";
  if (setting == "columns") return "time/px/py/pz";
  if (setting == "unit") return "mm/ms";
  if (setting == "drawn") return "yes";
  return setting == "grip" ? "200" : "0.01";
}

}  // namespace

TEST_CASE("every key of a scene that help lists is read, and every key that is read is listed") {
  std::set<std::string> listed, read;
  for (const std::string& table : scene_sections()) listed.insert(table);
  for (const DeclaredTable& table : scene_tables())
    for (const Declared& row : table.rows) listed.insert(table.name + "." + row.name);
  for (const std::vector<std::string>& overrides : {std::vector<std::string>{},
                                                    {"clamp.below={axis=\"z\",share=0.2}"},
                                                    {"contact.node=0"},
                                                    {"body.fine={elements=2000}"}})
    read.merge(scene_keys_read(built_in_scene_text(), overrides));
  CHECK(read == listed);
}

TEST_CASE("a key that is read but not declared is an error of the program, whatever the scene says") {
  const SceneDocument scene = SceneDocument::parse("[body]\nlength = 1.0\n", "scene", {});
  const SceneTable body = scene.root({"body"}).sub("body", {"length"});
  CHECK(body.number("length", positive()) == 1.0);
  CHECK_THROWS_AS(body.number("width", positive()), std::logic_error);
  CHECK_THROWS_AS(body.has("width"), std::logic_error);
}

TEST_CASE("the defaults that help prints are those of a scene that says nothing") {
  const Scene scene = built_in_scene();
  CHECK(default_of("model", "kernel") == name(scene.model.kernel));
  CHECK(default_of("model", "data").starts_with(name(scene.model.data)));
  CHECK(default_of("model", "neighbours").starts_with(std::to_string(scene.model.neighbours) + ";"));
  CHECK(default_of("body", "element") == (scene.body->element == Element::linear ? "linear" : "quadratic"));
  CHECK(default_of("state_space", "spacing").ends_with("0.006 with a phantom"));
  CHECK(default_of("session", "seconds") == "20");
  CHECK(default_of("session", "device") == "path:press,speed=0.06");
  CHECK(default_of("session.limits", "force") == "12");
}

TEST_CASE("every default of a number, a word or a flag that help prints is accepted when it is written") {
  std::vector<std::string> overrides;
  for (const char* table : {"model", "session", "session.jnd", "session.limits"})
    for (const Declared& row : scene_table(table).rows) {
      const bool one_word = !row.standard.empty() && row.standard.find(' ') == std::string::npos;
      if (one_word) overrides.push_back(std::string(table) + "." + row.name + "=" + row.standard);
    }
  CHECK(overrides.size() > 20);
  CHECK_NOTHROW(built_in_scene(overrides));
}

TEST_CASE("every setting of a device that help lists is read, and no other is accepted") {
  for (const DeclaredTable& kind : device_tables()) {
    if (kind.name != "path" && kind.name != "trace" && kind.name != "hand") continue;
    const std::string start = kind.name + (kind.name == "path"   ? ":line"
                                           : kind.name == "hand" ? ":omega"
                                                                 : ":a.csv");
    REQUIRE(kind.rows.size() > 2);
    for (std::size_t i = 1; i < kind.rows.size(); ++i) {
      const std::string& setting = kind.rows[i].name;
      CHECK_NOTHROW(device_from_text(start + "," + setting + "=" + value_for(setting)));
    }
    CHECK_THROWS_AS(device_from_text(start + ",nothing=1"), InputError);
  }
}

TEST_CASE("every key of a study that help lists is accepted, and no other") {
  const StudyFixture folder;
  const std::vector<DeclaredTable> tables = study_tables();
  REQUIRE(tables.size() == 4);
  CHECK(names_of(tables[3].rows) == std::vector<std::string>{"travel", "share", "tolerance", "low", "high"});
  std::string sustained = "seeds = [1]\n[sustained]\n", vary = "seeds = [1]\n[vary]\n";
  for (const Declared& row : tables[3].rows) sustained += row.name + " = " + row.standard + "\n";
  CHECK_NOTHROW(read_study(folder.study(sustained), {}));
  for (const Declared& row : tables[1].rows)
    if (row.name != "cost" && row.name.find_first_of("\" ") == std::string::npos)
      vary += row.name + " = [1.5, 2.5]\n";
  CHECK(read_study(folder.study(vary), {}).axes.size() == 7);
  CHECK_THROWS_AS(read_study(folder.study("seeds = [1]\nfoo = 1\n"), {}), InputError);
  CHECK_THROWS_AS(read_study(folder.study("seeds = [1]\n[sustained]\nfoo = 1\n"), {}), InputError);
}

TEST_CASE("every row of the reference has a name and a meaning, and no table has a name twice") {
  for (const HelpTopic& topic : help_topics())
    for (const DeclaredTable& table : topic.tables) {
      INFO(topic.name << " " << table.name);
      std::set<std::string> names;
      for (const Declared& row : table.rows) {
        CHECK(names.insert(row.name).second);
        CHECK_FALSE(row.meaning.empty());
      }
    }
}

TEST_CASE("help lists its topics, prints one topic, and narrows it to a table") {
  const Workshop shop;
  const auto topics = shop.run("help");
  for (const char* topic : {"help scene", "help study", "help devices", "help outputs"})
    CHECK_THAT(topics.out, Contains(topic));
  const auto material = shop.run("help scene material");
  CHECK_THAT(material.out, Contains("young [Pa]") && !Contains("neighbours"));
  CHECK_THAT(shop.forefeel("help scene session").out, Contains("session.jnd"));
  CHECK_THAT(shop.forefeel("help outputs frames.csv").out, Contains("fx,fy,fz [N]"));
  const json document = shop.json("help devices");
  CHECK(document["topics"][0]["tables"][0]["rows"][1]["name"] == "speed");
  CHECK(shop.files().empty());
}

TEST_CASE("help finds tables, keys and commands by their own names") {
  const Workshop shop;
  CHECK_THAT(shop.run("help path").out,
             Catch::StartsWith("forefeel help devices:\npath") && Contains("speed"));
  CHECK_THAT(shop.run("help session").out,
             Contains("session.limits") && Contains("first visit") && Contains("forefeel session --help"));
  CHECK_THAT(shop.run("help spacing").out, Contains("state_space") && !Contains("tolerance [1]"));
  CHECK(shop.json("help state_space.spacing")["topics"][0]["tables"][0]["rows"].size() == 1);
  CHECK_THAT(shop.run("help replay").out, Contains("forefeel replay --help"));
  for (const char* word : {"safe ", "sparse ", "gap ", "blank ", "forefeel classify"})
    CHECK_THAT(shop.run("help labels").out, Contains(word));
  CHECK_THAT(shop.run("help glossary").out, Contains("slewed") && Contains("regret"));
}

TEST_CASE("a topic or table that help does not know is refused with the nearest one") {
  const Workshop shop;
  check_refused(shop, "help scenes", {"unknown topic", "did you mean 'scene'"});
  check_refused(
      shop, "help sesion",
      {"unknown topic", "scene, study, devices, outputs, labels, bodies, models, report, words", "--help"});
  check_refused(shop, "help scene materials", {"unknown table", "did you mean 'material'"});
  check_refused(shop, "help scene -o a.txt", {"a.txt", ".html"});
}

TEST_CASE("the page of the reference holds every name of every topic") {
  const Workshop shop;
  shop.run("help -o help.html");
  const std::string page = shop.read("help.html");
  CHECK_THAT(page, Catch::StartsWith("<!DOCTYPE html>") && !Contains("src="));
  for (const HelpTopic& topic : help_topics())
    for (const DeclaredTable& table : topic.tables)
      for (const Declared& row : table.rows)
        if (row.name.find_first_of(",\"<&") == std::string::npos)
          CHECK_THAT(page, Contains("<code>" + row.name + "</code>"));
}
