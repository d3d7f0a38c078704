// [hand] of a scene: the same as session.device = "hand:…".

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_session.hpp"
#include "tests/support/executable.hpp"

namespace {

Scene load(const Workshop& shop, const std::string& text) {
  return load_scene(shop.write("scene.toml", beam_scene(text)));
}

}  // namespace

TEST_CASE("the table of a hand is read as the text of the device") {
  const Workshop shop;
  const Scene scene = load(shop, R"([hand]
profile = "omega"
target = "circle"
grip = "light"
speed = 0.05
stiffening = 0.5
drawn = true
)");
  CHECK(to_text(device_of(scene)) ==
        "hand:omega,target=circle,grip=light,speed=0.05,stiffening=0.5,drawn=yes");
  const HandMotion hand = std::get<HandMotion>(device_of(scene).motion());
  CHECK(hand.grip == 100);
  CHECK(hand.traits.stiffening == 0.5);
  CHECK(hand.traits.drawn);
  CHECK(hand.target.path == PathName::circle);
  CHECK(to_text(device_of(load(shop, "[hand]\nprofile = \"touch\"\ngrip = 250\n"))) == "hand:touch,grip=250");
}

TEST_CASE("a hand beside a device, without a profile or with an unknown key is refused") {
  const Workshop shop;
  CHECK_THROWS_WITH(load(shop, "[session]\ndevice = \"path:press\"\n[hand]\nprofile = \"omega\"\n"),
                    Contains("only one of"));
  CHECK_THROWS_WITH(load(shop, "[hand]\ngrip = 300\n"), Contains("profile"));
  CHECK_THROWS_WITH(load(shop, "[hand]\nprofile = \"omega\"\ngrib = 300\n"), Contains("grib"));
}
