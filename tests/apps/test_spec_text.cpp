#include "apps/scene/spec_text.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/workers/cost.hpp"
#include "tests/support/test.hpp"

namespace {

std::string device_refusal(const std::string& text) {
  return error_of([&] { device_from_text(text); });
}
std::string cost_refusal(const std::string& text) {
  return error_of([&] { cost_from_text(text); });
}

}  // namespace

TEST_CASE("devices are read as they are written and print the same") {
  const DeviceSpec path = device_from_text("path:circle,noise=1e-5,speed=0.060,amplitude=0.02,tremor=0.0001");
  const auto& motion = std::get<PathMotion>(path.motion());
  CHECK(motion.path == PathName::circle);
  CHECK(motion.speed == 0.06);
  CHECK(motion.amplitude == 0.02);
  CHECK(motion.tremor == 0.0001);
  CHECK(motion.noise == 1e-5);
  CHECK(to_text(path) == "path:circle,noise=1e-5,speed=0.060,amplitude=0.02,tremor=0.0001");
  CHECK_FALSE(std::get<PathMotion>(device_from_text("path:press").motion()).speed);
  for (const std::string& name : path_names()) CHECK(device_refusal("path:" + name).empty());

  const auto trace =
      std::get<TraceMotion>(device_from_text("trace:a/b.csv,scale=-2,offset=0.01/0/-1").motion());
  CHECK(trace.file == "a/b.csv");
  CHECK(trace.scale == -2);
  CHECK(trace.offset == Vec3(0.01, 0, -1));

  const auto hand =
      std::get<HandMotion>(device_from_text("hand:premium,target=line,grip=450,speed=0.1").motion());
  CHECK(hand.profile == HandName::premium);
  CHECK(hand.target.path == PathName::line);
  CHECK(hand.target.speed == 0.1);
  CHECK(hand.grip == 450);
  for (const auto& [word, grip] : {std::pair{"light", 100.0}, {"medium", 300.0}, {"firm", 800.0}})
    CHECK(std::get<HandMotion>(device_from_text(std::string("hand:touch,grip=") + word).motion()).grip ==
          grip);
  for (const std::string& name : hand_names()) CHECK(device_refusal("hand:" + name).empty());
}

TEST_CASE("what no device can be is refused in one line") {
  for (const std::string text :
       {"path", "path:", "path:spiral", "path:press,speed=fast", "path:press,speed=-1", "path:press,speed=0",
        "path:press,speed=nan", "path:press,speed=1e9", "path:press,amplitude=1e9",
        "path:press,speed=1,speed=2", "path:press,colour=red", "path:press,speed", "path:press,,speed=1",
        "hand:thumb", "", "trace:", "trace:a.csv,offset=1/2", "trace:a.csv,scale=big", "mouse:left"}) {
    CAPTURE(text);
    CHECK_FALSE(device_refusal(text).empty());
    CHECK_THAT(device_refusal(text), !Contains("\n"));
  }
  CHECK_THAT(device_refusal("path:spiral"), Contains("device: unknown path 'spiral', expected one of press"));
  CHECK_THAT(device_refusal("path:press,speed=2000"),
             Catch::Equals("device path:press,speed=2000: speed is 2000, expected at most 1000 m/s"));
  CHECK_THAT(device_refusal("hand:glove"), Contains("expected one of touch, premium, omega, falcon"));
  CHECK_THAT(device_refusal("hand:touch,grip=strong"), Contains("light, medium, firm"));
  CHECK_THAT(device_refusal("hand:touch,grip=0"), Contains("at least 1"));
  CHECK_THAT(device_refusal("hand:touch,target=nowhere"), Contains("unknown path 'nowhere'"));
  CHECK_THAT(device_refusal("hand:touch,weight=3"), Contains("unknown setting 'weight'"));
  CHECK_THAT(device_refusal("hand:"), Contains("expected a name"));
  CHECK_THAT(device_refusal("mouse:left"), Contains("unknown kind 'mouse', expected path:NAME, trace:FILE"));
}

TEST_CASE("costs are read as they are written; what none can be is refused") {
  CHECK(std::get<ConstantCost>(cost_from_text("constant:0.020").cost()).seconds == 0.02);
  CHECK(to_text(cost_from_text("constant:0.020")) == "constant:0.020");
  const auto lognormal = std::get<LogNormalCost>(cost_from_text("lognormal:0.05,0").cost());
  CHECK(lognormal.median == 0.05);
  CHECK(lognormal.sigma == 0);
  CHECK(std::holds_alternative<PaperCost>(cost_from_text("paper").cost()));
  CHECK(std::holds_alternative<RecordedCost>(cost_from_text("recorded").cost()));
  for (const std::string text :
       {"", "constant", "constant:", "constant:0", "constant:-1", "constant:nan", "constant:1,2",
        "lognormal:1", "lognormal:0,1", "lognormal:1,-1", "paper:1", "free", "constant:1e9"}) {
    CAPTURE(text);
    CHECK_THAT(cost_refusal(text), Catch::StartsWith("cost " + text + ": "));
  }
  CHECK_THAT(cost_refusal("free"), Contains("constant:SECONDS, lognormal:MEDIAN,SIGMA, recorded"));
}

TEST_CASE("parts are names with settings in their order") {
  CHECK(part_from_text("policy", "coverage") == Registered("coverage"));
  const Registered part = part_from_text("policy", "mine:a.csv,gain=2,b=");
  CHECK(part == Registered("mine", {{"", "a.csv"}, {"gain", "2"}, {"b", ""}}));
  CHECK(to_text(part) == "mine:a.csv,gain=2,b=");
  CHECK(error_of([] { part_from_text("policy", "mine:gain=2,more"); }) ==
        "policy mine:gain=2,more: 'more' is not a setting, expected key=value");
}
