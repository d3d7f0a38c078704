#include "allocation_count.hpp"
#include "approx/model/updater.hpp"
#include "geometry/coverage/state_space.hpp"
#include "scheduling/render/render_loop.hpp"
#include "small_body.hpp"

namespace {

State stiffening(const Vec3& x) {
  State state;
  state.at = x;
  state.force = -(80 + 2e5 * x.squaredNorm()) * x;
  state.stiffness = (80 + 2e5 * x.squaredNorm()) * Mat3::Identity() + 4e5 * x * x.transpose();
  return state;
}

// A minimal planner for the loop: it publishes a new model every few frames and reuses models that the loop
// returns.
class Feeder {
 public:
  Feeder(LoopLink& link, ModelOptions options)
      : link_(link), space_(small_input().touched.space), updater_(space_, options) {
    positions_ = lattice(space_.options().box, space_.options().spacing);
    for (int i = 0; i < 6; ++i) {
      models_.push_back(std::make_unique<Model>());
      free_.push_back(models_.back().get());
    }
  }
  void feed(const Vec3& hip) {
    while (const auto back = link_.returned.pop()) free_.push_back(const_cast<Model*>(*back));
    for (int i = 0; i < 3 && next_ < positions_.size(); ++i) space_.insert(stiffening(positions_[next_++]));
    REQUIRE(!free_.empty());
    Model* model = free_.back();
    free_.pop_back();
    updater_.update(hip, *model);
    ++published;
    if (const auto missed = link_.models.publish(model); missed && *missed)
      free_.push_back(const_cast<Model*>(*missed));
  }
  std::size_t free_models() {
    while (const auto back = link_.returned.pop()) free_.push_back(const_cast<Model*>(*back));
    return free_.size();
  }
  std::size_t published = 0;

 private:
  LoopLink& link_;
  StateSpace space_;
  ModelUpdater updater_;
  std::vector<Vec3> positions_;
  std::size_t next_ = 0;
  std::vector<std::unique_ptr<Model>> models_;
  std::vector<Model*> free_;
};

}  // namespace

TEST_CASE("a frame allocates nothing, under every rule, with models coming and going") {
  if (!FOREFEEL_COUNTS_ALLOCATIONS) skip("allocations are not counted under a sanitizer");
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    for (const PathMotion& spec :
         {PathMotion{.path = PathName::tour, .tremor = 0.0001, .noise = 0.00002}, PathMotion{}}) {
      CAPTURE(name(spec.path));
      const SessionInput input = small_input();
      RenderOptions options;
      options.switching.rule = rule;
      options.passivity.mode = spec.noise > 0 ? Passivity::control : Passivity::observe;
      options.passivity.coupling = 60;
      const auto device = make_device(spec, {.box = input.touched.space.box, .seed = 1, .folder = {}});
      LoopLink link;
      RenderLoop loop(*device, link, options, 1500);
      Feeder feeder(link, {.neighbours = 30});
      std::size_t during = 0;
      for (std::size_t k = 0; k < 1500; ++k) {
        if (k >= 100 && k % 7 == 0) feeder.feed(loop.hip().at);
        const std::size_t before = test::allocations();
        loop.frame(k);
        loop.note_timing(1, 2);
        during += test::allocations() - before;
      }
      CHECK(during == 0);
      CHECK(loop.lost_models() == 0);
      CHECK(feeder.free_models() >= 6 - 4);  // at most: two or three in the loop, one not taken
      if (FOREFEEL_COUNTS_ALLOCATIONS) {
        const std::size_t before = test::allocations();
        const auto probe = std::make_unique<double>(1.0);
        CHECK(test::allocations() == before + 1);  // the counter counts
      }
    }
  }
}

TEST_CASE("the loop logs what it renders and accounts for every switch") {
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    const SessionInput input = small_input();
    RenderOptions options;
    options.switching.rule = rule;
    options.safety.ramp_seconds = 0;
    const auto device = make_device(PathMotion{.path = PathName::tour},
                                    {.box = input.touched.space.box, .seed = 1, .folder = {}});
    LoopLink link;
    RenderLoop loop(*device, link, options, 1000);
    Feeder feeder(link, {.neighbours = 30});
    for (std::size_t k = 0; k < 1000; ++k) {
      if (k % 50 == 20) feeder.feed(loop.hip().at);
      loop.frame(k);
    }
    const auto log = loop.take_log();
    REQUIRE(log.size() == 1000);
    std::size_t over = 0, taken = 0;
    for (std::size_t k = 0; k < log.size(); ++k) {
      CHECK(log[k].t == static_cast<double>(k) / 1000);
      CHECK(log[k].at == device->position(log[k].t, {}));
      if (k < 20) CHECK(log[k].force == Vec3::Zero());  // before the first model
      over += log[k].step.change > log[k].step.bound;
      taken += log[k].step.took_model;
      if (k > 0) CHECK(log[k].step.model >= log[k - 1].step.model);
      if (k < 500) CHECK(log[k].sent.isApprox(log[k].force));  // no safety measure was needed
    }
    CHECK(taken > 0);
    CHECK(taken <= feeder.published);
    if (rule != SwitchRule::none) CHECK(over == 0);
    if (rule == SwitchRule::none) CHECK(taken == feeder.published);
  }
}

TEST_CASE("a device that fails holds its place, a silent planner fades the force") {
  class Failing final : public Device {
   public:
    Vec3 position(double t, const Vec3&) noexcept override {
      return t < 0.01 ? Vec3(0.001, 0, 0) : Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    }
    double duration() const override { return 1; }
  } device;
  LoopLink link;
  RenderOptions options;
  RenderLoop loop(device, link, options, 2000);
  for (std::size_t k = 0; k < 2000; ++k) loop.frame(k);
  CHECK(loop.hip().at == Vec3(0.001, 0, 0));
  CHECK(loop.safety().counts().stale ==
        2000 - 501);  // no beat after t = 0: stale once older than half a second
}
