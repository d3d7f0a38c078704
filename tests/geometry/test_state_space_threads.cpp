#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <thread>

#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/shared_state_space.hpp"

using namespace forefeel;

TEST_CASE("many threads query while one inserts, and labels only improve") {
  constexpr double h = 0.006;
  const std::vector<Vec3> states = make_setup("full", {.depth = 2, .half_width = 2, .width = 0.012}).states;
  for (const int readers : {1, 2, 3, 7}) {
    SharedStateSpace shared({.spacing = h});
    std::atomic<bool> done{false};
    std::atomic<int> worse{0}, asked{0};
    std::vector<std::thread> threads;
    for (int r = 0; r < readers; ++r)
      threads.emplace_back([&, r] {
        std::mt19937_64 random(static_cast<std::uint64_t>(r));
        std::uniform_real_distribution<double> uniform(-3 * h, 3 * h);
        std::vector<Vec3> places;
        for (int i = 0; i < 8; ++i)
          places.push_back(i % 2 ? Vec3(uniform(random), uniform(random), uniform(random))
                                 : states[static_cast<std::size_t>(15 * i)]);
        std::vector<Label> last(places.size(), Label::blank);
        std::vector<StateId> near;
        bool final_round = false;
        while (!final_round) {
          final_round = done.load();
          for (std::size_t i = 0; i < places.size(); ++i) {
            const Label now = shared.read([&](const StateSpace& space) {
              space.nearest(places[i], 5, near);
              const Coverage c = space.coverage(places[i]);
              return c.label == space.label(places[i]) ? c.label : Label::blank;
            });
            if (now > last[i]) ++worse;
            last[i] = now;
            ++asked;
          }
          std::this_thread::yield();
        }
      });
    for (const Vec3& p : states) {
      State state;
      state.at = p;
      REQUIRE(shared.insert(state).is_new);
    }
    done = true;
    for (std::thread& t : threads) t.join();
    CHECK(worse == 0);
    CHECK(asked > 0);
    CHECK(shared.read([](const StateSpace& space) { return space.size(); }) == states.size());
    CHECK(shared.read([](const StateSpace& space) {
      return space.label({0.001, 0.001, 0.002});
    }) == Label::safe);
  }
}
