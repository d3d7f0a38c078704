// The chance of an error above the JND that a state removes: against numerical integration, what it learns from the
// errors of states, and its placebo.

#include "scheduling/policy/error_need.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.005;

StateSpace space_with(const std::vector<Vec3>& at) {
  StateSpace space({.spacing = h, .box = {Vec3::Constant(-0.03), Vec3::Constant(0.03)}});
  for (const Vec3& x : at) {
    State state;
    state.at = x;
    state.force = -x;
    space.insert(state);
  }
  return space;
}

// A hand that holds still at x.
std::vector<Prediction> still_at(const Vec3& x) {
  return {{.horizon = 0, .at = x, .deviation = 0.0}, {.horizon = 0.1, .at = x, .deviation = 0.0}};
}

// The share of m e^{v Z} above 1, by the midpoint rule over the normal variable Z.
double above_one(double m, double v) {
  double sum = 0;
  constexpr double step = 1e-4;
  for (double z = -9 + step / 2; z < 9; z += step)
    sum += (m * std::exp(v * z) > 1 ? 1 : 0) * std::exp(-0.5 * z * z) * step / std::sqrt(2 * M_PI);
  return sum;
}

}  // namespace

TEST_CASE("the worth of a state is the chance of an error above the JND that it removes, per second") {
  const StateSpace space = space_with({Vec3(0.01, 0, 0)});
  const Vec3 hand(0, 0, 0);
  const std::vector<Prediction> path = still_at(hand);
  const PlannerView view{.space = space, .hip = {}, .predicted = path, .solve_seconds = 0.02, .pending = {}};
  ErrorNeed need({.path_share = 1});
  need.look(view);
  std::vector<Candidate> candidates(3);
  candidates[0].at = Vec3(-0.005, 0, 0);  // 1 h from the hand; the known state is 2 h away
  candidates[1].at = Vec3(-0.0025, 0, 0);
  candidates[2].at = Vec3(-0.02, 0, 0);  // farther than the known state: removes nothing
  std::vector<double> worth(3);
  need.worth(candidates, worth);
  const double v = need.fit().deviation();
  const double now = above_one(need.fit().median(2, 1), v);
  CHECK(worth[0] == Approx((now - above_one(need.fit().median(1, 1), v)) / 0.02).epsilon(0.01));
  CHECK(worth[1] == Approx((now - above_one(need.fit().median(0.5, 1), v)) / 0.02).epsilon(0.01));
  CHECK(worth[2] == 0);
  // A state being solved at half the distance leaves less to remove.
  const std::vector<Vec3> pending{Vec3(0, 0.005, 0)};
  need.pend(pending);
  std::vector<double> left(3);
  need.worth(candidates, left);
  CHECK(left[0] == Approx(0).margin(1e-9 * worth[0]));
  CHECK(left[1] ==
        Approx((above_one(need.fit().median(1, 1), v) - above_one(need.fit().median(0.5, 1), v)) / 0.02)
            .epsilon(0.03));
}

TEST_CASE("the estimate learns the order of the error from the errors of states") {
  std::vector<Vec3> at;
  std::vector<float> surprises;
  for (int i = 0; i < 120; ++i) {  // along a line, ever closer: the error is 3 (delta / h)^3
    const double gap = h * (0.4 + 0.02 * (i % 30));
    at.push_back(at.empty() ? Vec3(-0.029, 0, 0)
                            : Vec3(at.back() + Vec3(i % 2 ? gap : -0.6 * gap, 0.3 * gap, 0)));
    double delta = 8 * h;
    for (std::size_t k = 0; k + 1 < at.size(); ++k) delta = std::min(delta, (at[k] - at.back()).norm());
    surprises.push_back(static_cast<float>(3 * std::pow(delta / h, 3)));
  }
  const StateSpace space = space_with(at);
  REQUIRE(space.size() == 120);
  const std::vector<Prediction> path = still_at(Vec3::Zero());
  ErrorNeed need({});
  need.look({.space = space, .hip = {}, .predicted = path, .pending = {}, .surprises = surprises});
  CHECK(std::log(need.fit().median(1, 0.7) / need.fit().median(0.5, 0.7)) / std::log(2.0) ==
        Approx(3).margin(0.6));
  CHECK(need.fit().deviation() < 1.2);  // the prior's
}

TEST_CASE("a state is worth more where states near it were surprises") {
  std::vector<Vec3> at;
  std::vector<float> surprises;
  for (int i = 0; i < 12; ++i)  // mirror images; the model missed those at x > 0
    for (const double side : {-1.0, 1.0}) {
      at.emplace_back(side * (0.015 + 0.002 * (i % 3)), 0.004 * (i % 4) - 0.006, 0.005 * (i / 4) - 0.005);
      surprises.push_back(side > 0 ? 5 : 0.2F);
    }
  const StateSpace space = space_with(at);
  REQUIRE(space.size() == at.size());
  const std::vector<Prediction> path{{.horizon = 0, .at = Vec3(-0.02, 0, 0.012), .deviation = 0},
                                     {.horizon = 0, .at = Vec3(0.02, 0, 0.012), .deviation = 0}};
  ErrorNeed need({.path_share = 1});
  need.look({.space = space, .hip = {}, .predicted = path, .pending = {}, .surprises = surprises});
  std::vector<Candidate> candidates(2);
  candidates[0].at = path[0].at;
  candidates[1].at = path[1].at;
  double worth[2];
  need.worth(candidates, worth);
  CHECK(worth[0] > 0);
  CHECK(worth[1] > 1.5 * worth[0]);
}

TEST_CASE("the placebo permutes the estimates by its seed, and repeats") {
  const StateSpace space =
      space_with({Vec3(0.01, 0, 0), Vec3(-0.02, 0.01, 0), Vec3(0, 0, 0.02), Vec3(0, -0.02, 0)});
  const std::vector<Prediction> path = still_at(Vec3::Zero());
  const PlannerView view{.space = space, .hip = {}, .predicted = path, .pending = {}};
  std::vector<Candidate> candidates(50);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    candidates[i].at = Vec3(0.001 * double(i) - 0.025, 0.004 * double(i % 7) - 0.014, 0.003);
  const auto worth = [&](bool shuffle, std::uint64_t seed) {
    ErrorNeed need({.shuffle = shuffle, .seed = seed});
    need.look(view);
    std::vector<double> out(candidates.size());
    need.worth(candidates, out);
    return out;
  };
  CHECK(worth(true, 1) == worth(true, 1));
  CHECK(worth(true, 1) != worth(true, 2));
  CHECK(worth(true, 1) != worth(false, 1));
  CHECK(worth(false, 1) == worth(false, 2));
}
