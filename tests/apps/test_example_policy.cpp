#include "tests/support/executable.hpp"

TEST_CASE("a policy of one's own is built and picked up by a study") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.4\ndevice = \"path:circle,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1]\n[vary]\npolicy = [\"ahead\", \"nearest\"]\n");
  CHECK(shop.forefeel("study study.toml -o out").code == 2);  // the plain command line does not know it
  const auto ran = shop.shell(executable() + "_example study study.toml -o out --json");
  REQUIRE(ran.code == 0);
  CHECK(ran.json()["cells"] == 2);
  const std::string table = shop.shell("cut -d, -f1 out/cells.csv").out;
  CHECK(table == "policy\nahead\nnearest\n");
}
