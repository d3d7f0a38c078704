// Const queries of a constant state space from many threads at once (also run under ThreadSanitizer).

#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/path_walk.hpp"
#include "tests/support/test.hpp"

namespace {

struct Answer {
  Label label = Label::blank, along_path = Label::blank;
  double spread = 0, delta = 0;
  std::vector<StateId> near;
  bool operator==(const Answer&) const = default;
};

std::vector<Answer> ask(const StateSpace& space, const std::vector<Vec3>& places) {
  std::vector<Answer> answers;
  PathWalk walk;
  for (const Vec3& q : places) {
    const Coverage c = space.coverage(q);
    Answer a{.label = c.label,
             .along_path = space.label(q, walk),
             .spread = c.spread,
             .delta = c.delta,
             .near = {}};
    space.nearest(q, 5, a.near);
    answers.push_back(std::move(a));
  }
  return answers;
}

}  // namespace

TEST_CASE("many threads query a state space and get what one thread gets") {
  constexpr double h = 0.006;
  StateSpace space({.spacing = h});
  for (const Vec3& p : make_setup("full", {.depth = 3, .half_width = 3, .width = 0.012}).states) {
    State state;
    state.at = p;
    REQUIRE(space.insert(state).is_new);
  }
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-6 * h, 6 * h);
  std::vector<Vec3> places;
  for (int i = 0; i < 300; ++i) places.push_back(Vec3(uniform(random), uniform(random), uniform(random)));
  const std::vector<Answer> alone = ask(space, places);
  for (const std::size_t count : {1u, 2u, 3u, 7u}) {
    std::vector<std::vector<Answer>> answers(count);
    std::vector<std::thread> threads;
    for (std::vector<Answer>& mine : answers) threads.emplace_back([&] { mine = ask(space, places); });
    for (std::thread& t : threads) t.join();
    for (const std::vector<Answer>& mine : answers) CHECK(mine == alone);
  }
  CHECK(space.label({0.001, 0.001, 0.002}) == Label::safe);
}
