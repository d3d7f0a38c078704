// Work at many points at once: the octree of all, the ball that places share, and a table read in parts. Each against
// brute force.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <random>

#include "geometry/coverage/place_walk.hpp"
#include "geometry/index/point_octree.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<Vec3> drawn_places(std::size_t n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> at(n);
  for (Vec3& x : at) x = Vec3(uniform(random), uniform(random), uniform(random));
  return at;
}

// Random places, heaps far apart, a lattice with ties, one place many times.
std::vector<std::vector<Vec3>> clouds(std::mt19937_64& random) {
  std::vector<std::vector<Vec3>> all{
      drawn_places(3000, random), {}, {}, std::vector<Vec3>(200, Vec3(1, 2, 3)), {Vec3(1, 1, 1)}};
  for (const Vec3& x : drawn_places(600, random))
    all[1].push_back((x.x() > 0 ? 1e3 : -1.0) * Vec3::Ones() + 1e-3 * x);
  for (int i = 0; i < 1000; ++i) all[2].emplace_back(i % 10, i / 10 % 10, i / 100);
  all[2].insert(all[2].end(), 40, Vec3(4, 4, 4));
  return all;
}

std::vector<PointOctree::Neighbour> by_distance(const std::vector<Vec3>& at, const Vec3& q) {
  std::vector<PointOctree::Neighbour> all;
  for (std::uint32_t i = 0; i < at.size(); ++i) all.push_back({(at[i] - q).squaredNorm(), i});
  std::ranges::sort(all, [](const auto& a, const auto& b) { return a < b; });
  return all;
}

}  // namespace

TEST_CASE("an octree of many points finds what brute force finds, and takes more points") {
  std::mt19937_64 random(3);
  for (std::vector<Vec3> at : clouds(random)) {
    PointOctree tree(at);
    REQUIRE(tree.size() == at.size());
    for (int round = 0; round < 2; ++round) {
      for (const Vec3& offset : drawn_places(40, random)) {
        const Vec3 q = at[static_cast<std::size_t>(random()) % at.size()] + offset;
        const std::vector<PointOctree::Neighbour> all = by_distance(at, q);
        std::vector<PointOctree::Neighbour> found;
        tree.nearest(q, 30, found);
        REQUIRE(found.size() == std::min<std::size_t>(30, at.size()));
        for (std::size_t i = 0; i < found.size(); ++i) REQUIRE(found[i].id == all[i].id);
        REQUIRE(tree.nearest(q).id == all[0].id);
        const double radius = 0.7;
        std::vector<StateId> within;
        tree.within(q, radius, within);
        const auto inside =
            std::ranges::count_if(all, [&](const auto& n) { return n.squared <= radius * radius; });
        REQUIRE(static_cast<long>(within.size()) == inside);
        REQUIRE(tree.has_two_within(q, radius) == (inside > 1));
        const Vec3 direction = offset.normalized();
        double most = -1e300;
        for (const Vec3& x : at) most = std::max(most, x.dot(direction));
        REQUIRE(at[tree.farthest(direction)].dot(direction) == most);
      }
      for (const Vec3& x : drawn_places(50, random)) {  // beyond its cube as well
        tree.insert(static_cast<std::uint32_t>(at.size()), 5 * x);
        at.push_back(5 * x);
      }
    }
  }
  CHECK(PointOctree(std::vector<Vec3>()).nearest(Vec3(0, 0, 0)).id == PointOctree::nobody);
  CHECK(PointOctree().farthest(Vec3(1, 0, 0)) == PointOctree::nobody);
}

TEST_CASE("distinct points are those that are far from every earlier one that stays") {
  std::mt19937_64 random(5);
  for (const double apart : {0.0, 0.3}) {
    for (std::vector<Vec3> at : clouds(random)) {
      std::vector<Vec3> kept;
      for (const Vec3& x : at)
        if (std::ranges::none_of(kept, [&](const Vec3& k) { return (k - x).squaredNorm() <= apart * apart; }))
          kept.push_back(x);
      const PointOctree tree = distinct_points(at, apart);
      CHECK(at == kept);
      CHECK(tree.size() == kept.size());
    }
  }
}

TEST_CASE("a walk finds the nearest states of brute force, near and far, while states are added") {
  std::mt19937_64 random(7);
  const std::vector<Vec3> at = drawn_places(2500, random);
  StateSpace space({.spacing = 0.1});
  std::vector<Vec3> known;
  const auto add = [&](std::size_t n) {
    for (const std::size_t end = known.size() + n; known.size() < end;) {
      State state;
      state.at = at[known.size()];
      known.push_back(state.at);
      space.insert(std::move(state));
    }
  };
  add(2000);
  PlaceWalk walk;
  std::vector<StateId> found;
  Vec3 q = Vec3::Zero();
  for (int step = 0; step < 600; ++step) {
    const Vec3 move = drawn_places(1, random).front();
    q = step % 50 == 49 ? Vec3(1.5 * move) : Vec3(q + 0.03 * move);
    if (step % 40 == 39) add(20);
    const std::size_t n = step % 3 == 0 ? 20 : 50;
    walk.nearest(space, q, n, found);
    const std::vector<PointOctree::Neighbour> all = by_distance(known, q);
    REQUIRE(found.size() == n);
    for (std::size_t i = 0; i < n; ++i) REQUIRE(found[i].value == all[i].id);
    REQUIRE(walk.label(space, q) == space.label(q));
  }
}

TEST_CASE("a long table is the same whatever the threads, and its errors name the line") {
  const TemporaryFolder folder;
  std::mt19937_64 random(9);
  const std::vector<Vec3> at = drawn_places(30'000, random);
  std::string text = "x,y,z\n";
  std::size_t line = 1;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (i % 1000 == 7) text += "# a remark\n\n", line += 2;
    text += fmt::format("{},{},{}\n", at[i].x(), at[i].y(), at[i].z()), ++line;
  }
  REQUIRE(text.size() > 1 << 20);  // parts
  const auto good = folder.write("good.csv", text), bare = folder.write("bare.csv", text.substr(6)),
             quoted = folder.write("quoted.csv", text + "\"1\",2,3\n"),
             bad = folder.write("bad.csv", text + "1,2\n" + text.substr(6));
  const int before = omp_get_max_threads();
  for (const int threads : {1, 2, 3, 7}) {
    omp_set_num_threads(threads);
    CHECK(read_points_csv(good) == at);
    CHECK(read_points_csv(bare) == at);
    CHECK(read_points_csv(quoted).size() == at.size() + 1);
    const StateTable table = read_table_csv(good);
    REQUIRE(table.states.size() == at.size());
    for (std::size_t i = 0; i < at.size(); ++i) REQUIRE(table.states[i].at == at[i]);
    CHECK_THAT(error_of([&] { read_points_csv(bad); }),
               Contains(fmt::format("bad.csv:{}: 2 columns, expected 3", line + 1)));
  }
  omp_set_num_threads(before);
}
