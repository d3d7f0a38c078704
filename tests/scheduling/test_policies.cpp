#include "scheduling/motion/device.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/policy/candidates.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policy.hpp"
#include "small_body.hpp"

namespace {

State spring(const Vec3& x) {
  State state;
  state.at = x;
  state.force = -100 * x;
  state.stiffness = 100 * Mat3::Identity();
  return state;
}

Vec3 draw(std::uint64_t key, double size) {
  return size * Vec3(2 * random::uniform(random::mix(key, 1)) - 1,
                     2 * random::uniform(random::mix(key, 2)) - 1,
                     2 * random::uniform(random::mix(key, 3)) - 1);
}

}  // namespace

TEST_CASE("priorities are finite and not negative for every policy and input") {
  StateSpace space(small_input().touched.space);
  space.insert(spring(Vec3::Zero()));
  constexpr double infinite = std::numeric_limits<double>::infinity();
  for (const std::string& name : policy_names()) {
    CAPTURE(name);
    const auto policy = make_policy(name, {.seed = 9});
    for (std::uint64_t i = 0; i < 300; ++i) {
      std::vector<Prediction> path;
      for (std::uint64_t k = 0; k < i % 4; ++k)
        path.push_back({.horizon = 0.1 * static_cast<double>(k),
                        .at = draw(1000 * i + k, 0.1),
                        .deviation = i % 3 == 0 ? 0.0 : 1e3});
      const double sizes[] = {0, 1e-12, 0.05, 1e6};
      const PlannerView view{
          .space = space,
          .now = 0.01 * static_cast<double>(i),
          .hip = {.t = 0, .at = draw(i, sizes[i % 4]), .velocity = draw(i + 7, sizes[(i / 4) % 4])},
          .predicted = path,
          .solve_seconds = i % 5 == 0 ? 0.0 : random::uniform(i),
          .workers = 1 + static_cast<int>(i % 7),
          .pending = {}};
      std::vector<Candidate> candidates;
      for (std::uint64_t k = 0; k < 20; ++k)
        candidates.push_back({.at = draw(i * 31 + k, sizes[k % 4]),
                              .region = static_cast<Label>(k % 4),
                              .requested = k % 3 == 0 ? infinite : random::uniform(k),
                              .delta = k % 5 == 0 ? infinite : random::uniform(k) * 0.1,
                              .order = static_cast<std::uint32_t>(k)});
      std::vector<double> priorities(candidates.size(), -1);
      policy->look(view);
      policy->prioritise(candidates, view, priorities);
      for (const double p : priorities) {
        REQUIRE(std::isfinite(p));
        REQUIRE(p >= 0);
      }
    }
  }
  CHECK_THROWS_AS(make_policy("best", {}), InputError);
}

TEST_CASE("policies prefer what their names say") {
  StateSpace space(small_input().touched.space);
  space.insert(spring(Vec3::Zero()));
  std::vector<Prediction> path;
  for (int i = 0; i <= 8; ++i)
    path.push_back({.horizon = 0.05 * i, .at = Vec3(0.06 * 0.05 * i, 0, 0), .deviation = 1e-3});
  const PlannerView view{.space = space,
                         .now = 1,
                         .hip = {.t = 1, .at = Vec3::Zero(), .velocity = Vec3(0.06, 0, 0)},
                         .predicted = path,
                         .solve_seconds = 0.01,
                         .workers = 2,
                         .pending = {}};
  const auto worth = [&](const std::string& name, const Candidate& c) {
    const auto policy = make_policy(name, {});
    policy->look(view);
    return policy->priority(c, view);
  };
  const Candidate ahead{
      .at = Vec3(0.012, 0, 0), .region = Label::blank, .requested = 2, .delta = 0.012, .order = 5};
  const Candidate behind{
      .at = Vec3(-0.006, 0, 0), .region = Label::blank, .requested = 1, .delta = 0.006, .order = 4};
  CHECK(worth("nearest", behind) > worth("nearest", ahead));
  CHECK(worth("fifo", behind) > worth("fifo", ahead));
  Candidate far_behind = behind;
  far_behind.at.x() = -0.012;
  for (const std::string name : {"direction", "coverage", "error"}) {
    CAPTURE(name);
    CHECK(worth(name, ahead) > worth(name, far_behind));
  }
  // Order by time to reach: positions that the hand has passed, or passes before they could be solved, come
  // last.
  PlannerView slow = view;
  slow.solve_seconds = 0.2;  // 12 mm of way
  const auto direction = make_policy("direction", {});
  const auto at = [&](double x, double y) {
    return direction->priority({.at = Vec3(x, y, 0), .delta = 0.01}, slow);
  };
  CHECK(at(0.018, 0) > at(0.024, 0));
  CHECK(at(0.018, 0) > at(0.018, 0.006));
  for (const double passed : {-0.001, -0.006, 0.004, 0.009}) {
    CAPTURE(passed);
    CHECK(at(0.024, 0.006) > at(passed, 0));
  }
  Candidate coarse = ahead, fine = ahead;
  coarse.at = Vec3(0, 0.024, 0);
  fine.at = Vec3(0, 0.018, 0);
  CHECK(worth("coarse-to-fine", coarse) > worth("coarse-to-fine", fine));
}

TEST_CASE("coverage: what is known or under way ahead is worth less") {
  StateSpaceOptions options = small_input().touched.space;
  options.box = {Vec3::Constant(-0.036), Vec3::Constant(0.036)};
  StateSpace empty(options), known(options);
  std::vector<Prediction> path;
  for (int i = 0; i <= 8; ++i)
    path.push_back({.horizon = 0.05 * i, .at = Vec3(0.02 * i / 8, 0, 0), .deviation = 1e-3});
  const Candidate ahead{.at = Vec3(0.018, 0, 0)}, aside{.at = Vec3(-0.024, 0.024, 0.024)};
  const auto worth = [&](const StateSpace& space, const Candidate& c, std::span<const Vec3> pending) {
    const PlannerView view{.space = space,
                           .now = 1,
                           .hip = {.t = 1, .at = Vec3::Zero(), .velocity = Vec3(0.05, 0, 0)},
                           .predicted = path,
                           .solve_seconds = 0.1,
                           .workers = 2,
                           .pending = pending};
    const auto policy = make_policy("coverage", {});
    policy->look(view);
    return policy->priority(c, view);
  };
  const double alone = worth(empty, ahead, {});
  CHECK(alone > 2 * worth(empty, aside, {}));
  const Vec3 near(0.012, 0, 0);
  CHECK(worth(empty, ahead, {&near, 1}) < 0.5 * alone);
  known.insert(spring(near));
  CHECK(worth(known, ahead, {}) < 0.5 * alone);  // its places have turned sparse
}

TEST_CASE("coverage: a model that interpolates in lattice cells gets the corners of those ahead first") {
  StateSpaceOptions options = small_input().touched.space;
  options.box = {Vec3::Constant(-0.036), Vec3::Constant(0.036)};
  StateSpace space(options);
  for (const Vec3& x :
       lattice(options.box, options.spacing))  // all but one corner: safe everywhere, yet a cell is open
    if ((x - Vec3(0.012, 0, 0)).norm() > 1e-6) space.insert(spring(x));
  std::vector<Prediction> path;
  for (int i = 0; i <= 8; ++i)
    path.push_back({.horizon = 0.05 * i, .at = Vec3(0.02 * i / 8, 0.001, 0.001), .deviation = 1e-3});
  const auto worth = [&](bool in_cells) {
    const PlannerView view{.space = space,
                           .now = 1,
                           .hip = {.t = 1, .at = path[0].at, .velocity = Vec3(0.05, 0, 0)},
                           .predicted = path,
                           .solve_seconds = 0.1,
                           .workers = 2,
                           .pending = {},
                           .in_cells = in_cells};
    const auto policy = make_policy("coverage", {});
    policy->look(view);
    return policy->priority({.at = Vec3(0.012, 0, 0), .delta = 0.006}, view);
  };
  CHECK(worth(true) > worth(false) + 0.01);
}

TEST_CASE("coverage: which spacing counts is learnt from what the states that came were missed by") {
  StateSpaceOptions options = small_input().touched.space;
  options.box = {Vec3::Constant(-0.048), Vec3::Constant(0.048)};
  StateSpace space(options);
  std::vector<float> surprises;
  for (const Vec3& x : lattice({Vec3::Constant(-0.048), Vec3(0, 0.048, 0.048)}, 0.024)) {
    space.insert(spring(x));
    surprises.push_back(0);
  }
  // One candidate in the middle of a coarse cell that is known, one where nothing is.
  const std::vector<Candidate> candidates{{.at = Vec3(-0.024, 0.012, 0.012)},
                                          {.at = Vec3(0.048, 0.012, 0.012)}};
  const std::vector<Prediction> path{{.horizon = 0, .at = Vec3(-0.036, 0.012, 0.012)},
                                     {.horizon = 0.1, .at = Vec3(-0.024, 0.012, 0.012)}};
  const auto fine_over_far = [&](float surprise) {
    std::ranges::fill(surprises, surprise);
    const PlannerView view{.space = space,
                           .now = 1,
                           .hip = {.t = 1, .at = path[0].at, .velocity = Vec3(0.1, 0, 0)},
                           .predicted = path,
                           .solve_seconds = 0.05,
                           .workers = 1,
                           .pending = {},
                           .with_stiffness = true,
                           .surprises = surprises};
    const auto policy = make_policy("coverage", {});
    policy->look(view);
    double worth[2];
    policy->prioritise(candidates, view, worth);
    return worth[0] / worth[1];
  };
  const double untold = fine_over_far(std::numeric_limits<float>::quiet_NaN()), smooth = fine_over_far(0.01F),
               hard = fine_over_far(20);
  CHECK(smooth < untold);
  CHECK(untold < hard);
}

TEST_CASE("coverage: motion straight out of the box is expected back") {
  StateSpace space(small_input().touched.space);  // 12 mm each way
  const std::vector<Prediction> path{{.horizon = 0, .at = Vec3(0.01, 0, 0)},
                                     {.horizon = 0.1, .at = Vec3(0.02, 0.01, 0)}};
  const std::vector<Candidate> candidates{
      {.at = Vec3(0.006, 0.012, 0)}, {.at = Vec3(0.006, -0.012, 0)}, {.at = Vec3(-0.012, -0.012, 0)}};
  const PlannerView view{.space = space,
                         .now = 1,
                         .hip = {.t = 1, .at = path[0].at, .velocity = Vec3(0.1, 0.1, 0)},
                         .predicted = path,
                         .solve_seconds = 0.1,
                         .workers = 1,
                         .pending = {}};
  const auto policy = make_policy("coverage", {});
  policy->look(view);
  double worth[3];
  policy->prioritise(candidates, view, worth);
  CHECK(worth[0] > worth[1]);
  CHECK(worth[1] > worth[2]);
}

TEST_CASE("the placebo permutes labels among the places and nothing else") {
  StateSpaceOptions options = small_input().touched.space;
  options.box = {Vec3::Constant(-0.036), Vec3::Constant(0.036)};
  StateSpace space(options);
  const PlannerView view{.space = space,
                         .now = 0,
                         .hip = {},
                         .predicted = {},
                         .solve_seconds = 0.01,
                         .workers = 1,
                         .pending = {}};
  std::vector<Candidate> candidates;
  for (std::uint64_t i = 0; i < 50; ++i) candidates.push_back({.at = draw(i, 0.036)});
  std::vector<double> truth(50), placebo(50);
  const auto ask = [&](const char* name, std::vector<double>& out) {
    const auto policy = make_policy(name, {.seed = 2});
    policy->look(view);
    policy->prioritise(candidates, view, out);
  };
  ask("coverage", truth);
  ask("shuffled", placebo);
  CHECK(truth == placebo);  // all is blank: there is nothing to permute
  for (int i = 0; i < 4; ++i) space.insert(spring(Vec3(0.02, 0.006 * i, 0.01)));
  ask("coverage", truth);
  ask("shuffled", placebo);
  CHECK(truth != placebo);
}

TEST_CASE("what places still need: products kept from call to call are those made anew") {
  std::vector<Vec3> at, under_way;
  std::vector<NeedLeft::Needs> needs;
  const auto place = [](std::uint64_t i) {
    return Vec3(0.07 * Vec3(random::uniform(random::mix(5, i)), random::uniform(random::mix(6, i)),
                            random::uniform(random::mix(7, i))));
  };
  for (std::uint64_t i = 0; i < 200; ++i) {
    at.push_back(place(i));
    needs.push_back(
        {random::uniform(random::mix(8, i)), random::uniform(random::mix(9, i)), i % 3 == 0 ? 0.0 : 1.0});
  }
  for (std::uint64_t i = 0; i < 60; ++i) under_way.push_back(place(1000 + i));
  under_way.push_back(at[3]);  // removes all need of that place
  NeedLeft::Needs inverses;
  for (std::size_t s = 0; s < 3; ++s) inverses[s] = 1 / std::pow(std::array{0.048, 0.024, 0.012}[s], 2);
  NeedLeft kept;
  kept.begin(at, needs, inverses);
  const auto expect = [&](const std::vector<Vec3>& now) {
    kept.set(now);
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t s = 0; s < 3; ++s) {
        double left = needs[i][s];
        for (const Vec3& p : now) left *= 1 - std::max(0.0, 1 - (at[i] - p).squaredNorm() * inverses[s]);
        REQUIRE(kept.left(i)[s] == Approx(left).epsilon(1e-9).margin(1e-193));
      }
  };
  expect({});
  for (const std::size_t n : {1u, 2u, 40u, 61u}) expect({under_way.begin(), under_way.begin() + n});
  for (const std::size_t out : {0u, 17u, 60u, 3u}) {
    std::vector<Vec3> fewer = under_way;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(out));
    expect(fewer);
  }
  expect(under_way);
  expect({under_way.begin() + 30, under_way.end()});
  std::reverse(under_way.begin(), under_way.end());
  expect(under_way);
  // Hundreds of states at one place make the need underflow to zero; with fewer of them it is positive again.
  for (int i = 0; i < 400; ++i) under_way.push_back(at[5] + Vec3(0.004, 0, 0));
  expect(under_way);
  expect({under_way.begin(), under_way.end() - 3});
  expect({under_way.begin(), under_way.begin() + 61});
}

TEST_CASE("candidates are the unknown lattice points, each once") {
  StateSpace space(small_input().touched.space);
  space.insert(spring(Vec3::Zero()));
  State failed = spring(Vec3(0.006, 0, 0));
  failed.solve.status = SolveStatus::diverged;
  LatticeCandidates candidates(space, std::vector<State>{failed});
  CHECK(candidates.open().size() == 123);
  for (const Candidate& c : candidates.open()) {
    REQUIRE(c.at.norm() > 1e-9);
    REQUIRE((c.at - failed.at).norm() > 1e-9);
    REQUIRE(c.delta == c.at.norm());
  }
  const Vec3 x(0, 0.006, 0);
  space.insert(spring(x));
  candidates.learn({.at = x});
  CHECK(candidates.open().size() == 122);
  const Candidate taken = candidates.take(17);
  CHECK(candidates.open().size() == 121);
  candidates.learn(taken);  // already taken: nothing to remove
  CHECK(candidates.open().size() == 121);
  candidates.put_back(taken);
  CHECK(candidates.open().size() == 122);
  std::set<std::uint32_t> orders;
  for (const Candidate& c : candidates.open()) orders.insert(c.order);
  CHECK(orders.size() == 122);
  candidates.learn({.at = Vec3(0.0031, 0.001, 0.0007)});  // off the lattice: no candidate goes
  CHECK(candidates.open().size() == 122);
}

TEST_CASE("predictors: exact on uniform motion, honest about their deviation") {
  for (const std::string& name : predictor_names()) {
    if (name == "network") continue;  // has no weights of its own
    CAPTURE(name);
    const auto predictor = make_predictor(name);
    const Vec3 velocity(0.03, -0.02, 0.01);
    for (int k = 0; k <= 2000; ++k)
      predictor->observe({.t = 1e-3 * k, .at = 1e-3 * k * velocity, .velocity = velocity});
    for (const double horizon : {0.0, 0.05, 0.2}) {
      const Prediction p = predictor->predict(horizon);
      CHECK((p.at - (2 + horizon) * velocity).norm() < 2e-5);
      CHECK(p.deviation >= 0);
    }
    CHECK(predictor->predict(0.4).deviation > predictor->predict(0.1).deviation);

    const auto device = make_device(PathMotion{.path = PathName::lissajous, .tremor = 0.0001},
                                    {.box = small_input().touched.space.box, .seed = 1, .folder = {}});
    std::vector<Vec3> motion;
    for (int k = 0; k < 8000; ++k) motion.push_back(device->position(1e-3 * k, {}));
    const double horizons[] = {0.02, 0.1, 0.3};
    const auto scored = make_predictor(name);
    PredictionScore score(*scored, 1e-3, horizons);
    for (const Vec3& at : motion) score.add(at);
    const auto errors = score.report();
    REQUIRE(errors.size() == 3);
    // Looking back from where the hand came to be.
    const auto again = make_predictor(name);
    std::vector<double> missed;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      again->observe({.t = 1e-3 * static_cast<double>(i), .at = motion[i], .velocity = Vec3::Zero()});
      if (i + 100 < motion.size()) missed.push_back((again->predict(0.1).at - motion[i + 100]).norm());
    }
    std::ranges::sort(missed);
    CHECK(errors[1].p50 == missed[missed.size() / 2]);
    CHECK(errors[1].p95 == missed[missed.size() * 95 / 100]);
    CHECK(errors[0].p50 < 1.05 * errors[1].p50);  // tremor is a floor
    CHECK(errors[1].p50 < errors[2].p50);
    CHECK(errors[0].p50 < 0.0005);
    CHECK(errors[1].within_deviation > 0.6);
  }
  CHECK_THROWS_AS(make_predictor("oracle"), InputError);
}
