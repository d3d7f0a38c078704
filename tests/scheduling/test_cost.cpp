#include "scheduling/motion/random.hpp"
#include "scheduling/record/needed_states.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

std::vector<double> draws(const CostModel& model, int count) {
  std::vector<double> costs;
  for (int i = 0; i < count; ++i) costs.push_back(model.seconds(Vec3(1e-3 * i, 2e-3 * i, -1e-3 * i)));
  std::sort(costs.begin(), costs.end());
  return costs;
}

const auto none = [] { return RecordedCosts{}; };

}  // namespace

TEST_CASE("cost models have the distribution they name") {
  CHECK(make_cost(ConstantCost{0.02}, {.seed = 1}, none)->seconds(Vec3::Zero()) == 0.02);
  const auto lognormal = draws(*make_cost(LogNormalCost{0.05, 0.5}, {.seed = 1}, none), 20000);
  CHECK(lognormal[10000] == Approx(0.05).epsilon(0.03));
  CHECK(std::log(lognormal[16827] / lognormal[3173]) / 2 == Approx(0.5).epsilon(0.03));  // +-1 sigma
  const auto paper = draws(*make_cost(PaperCost{}, {.seed = 1}, none), 20000);
  CHECK(paper.front() >= 0.1);
  CHECK(paper.back() <= 1.0);
  CHECK(paper[10000] == Approx(std::sqrt(0.1)).epsilon(0.03));
  const auto recorded = draws(*make_cost(RecordedCost{}, {.seed = 1},
                                         [] {
                                           return RecordedCosts{{0.01, 0.03, 0.02}, 0.004};
                                         }),
                              20000);
  CHECK(recorded.front() >= 0.01);
  CHECK(recorded.back() <= 0.03);
  CHECK(recorded[10000] == Approx(0.02).epsilon(0.02));
}

TEST_CASE("the state at rest costs one of four iterations, or what was measured") {
  CHECK(make_cost(ConstantCost{0.02}, {.seed = 1}, none)->rest_seconds() == Approx(0.005));
  const auto paper = make_cost(PaperCost{}, {.seed = 7}, none);
  CHECK(paper->rest_seconds() == Approx(0.25 * paper->seconds(Vec3::Zero())));
  CHECK(make_cost(RecordedCost{}, {.seed = 1}, [] {
          return RecordedCosts{{0.01, 0.03}, 0.004};
        })->rest_seconds() == 0.004);
}

TEST_CASE("a cost depends on seed and place alone") {
  const auto a = make_cost(PaperCost{}, {.seed = 5}, none), b = make_cost(PaperCost{}, {.seed = 5}, none),
             other = make_cost(PaperCost{}, {.seed = 6}, none);
  const Vec3 x(0.006, -0.012, 0.018), y(0.012, -0.012, 0.018);
  const double first = a->seconds(x);
  a->seconds(y);
  CHECK(a->seconds(x) == first);
  CHECK(b->seconds(x) == first);
  CHECK(b->seconds(x + Vec3::Constant(1e-9)) == first);  // round-off of a lattice point
  CHECK(b->seconds(y) != first);
  CHECK(other->seconds(x) != first);
}

TEST_CASE("costs outside their ranges are refused, and each prints as it is written on the command line") {
  const CostSpec bad[] = {ConstantCost{0},        ConstantCost{-1},      ConstantCost{std::nan("")},
                          ConstantCost{1e9},      LogNormalCost{0, 1},   LogNormalCost{1, -1},
                          LogNormalCost{1, 1e99}, LogNormalCost{1e7, 1}, Registered("free")};
  for (const CostSpec& cost : bad) {
    CAPTURE(to_text(cost));
    CHECK_THROWS_AS(make_cost(cost, {.seed = 1}, none), InputError);
  }
  CHECK_THROWS_AS(make_cost(RecordedCost{}, {.seed = 1}, none), InputError);
  CHECK_NOTHROW(check(CostSpec(RecordedCost{})));
  CHECK(to_text(CostSpec()) == "constant:0.01");
  CHECK(to_text(CostSpec(LogNormalCost{0.1, 0.5})) == "lognormal:0.1,0.5");
  CHECK(to_text(CostSpec(PaperCost{})) == "paper");
  CHECK(to_text(CostSpec(RecordedCost{})) == "recorded");
  CHECK(to_text(CostSpec(ConstantCost{0.01}, "constant:0.010")) == "constant:0.010");
}

TEST_CASE("recorded costs are measured once, however many ask at the same time; rest has no -0") {
  const SessionInput input = small_input();
  ReferenceService service(reference_options(input), 2);
  RecordedCosts lists[4];
  {
    std::vector<std::jthread> threads;
    for (auto& list : lists) threads.emplace_back([&] { list = service.recorded_costs(); });
  }
  CHECK(lists[0].solves.size() == 48);
  CHECK(lists[0].rest > 0);
  for (const auto& list : lists) CHECK(list.solves == lists[0].solves);
  for (const auto& list : lists) CHECK(list.rest == lists[0].rest);
  const State rest = service.get(Vec3::Zero());
  for (int i = 0; i < 3; ++i) CHECK_FALSE((rest.force[i] == 0 && std::signbit(rest.force[i])));
}

TEST_CASE("a reference is waited for as long as is said, and is there later all the same") {
  const SessionInput input = small_input();
  ReferenceService service(reference_options(input), 1);
  const auto now = std::chrono::steady_clock::now();
  const Vec3 x(0.003, -0.002, 0.001), y(0.001, 0.002, -0.003);
  for (int i = 1; i <= 1000; ++i) service.request(1e-6 * i * y);  // what one thread does not do at once
  // A solve may end before it is asked about, though hardly each of twenty.
  std::size_t late = 0;
  for (int i = 1; i <= 20; ++i) late += !service.get_until(x + 1e-5 * i * y, now - std::chrono::seconds(1));
  CHECK(late > 0);
  const std::optional<State> later = service.get_until(x, now + std::chrono::hours(1));
  REQUIRE(later);
  CHECK(later->usable());
  CHECK(later->force == service.get(x).force);
  CHECK(service.get_until(x, now - std::chrono::seconds(1)));  // solved: nothing to wait for
  CHECK(service.get(y).usable());
}

TEST_CASE("states that a motion needs: corners of visited cells, faces of the box among them") {
  const Box box{Vec3::Constant(-0.036), Vec3::Constant(0.036)};  // 6 x 0.006 is more than 0.036
  NeededStates needed(box, 0.006);
  needed.visit(Vec3::Constant(0.035));
  CHECK(needed.count() == 8);
  needed.visit(Vec3::Constant(0.037));  // outside but for the corner
  CHECK(needed.count() == 8);
  needed.visit(Vec3(0.029, 0.035, 0.035));
  CHECK(needed.count() == 12);
}
