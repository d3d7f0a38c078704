#include <Eigen/Geometry>

#include "geometry/coverage/setups.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/cone.hpp"
#include "geometry/index/delaunay_index.hpp"
#include "tests/support/test.hpp"

namespace {

constexpr double h = 0.006;

State state_at(const Vec3& at, double energy = unknown) {
  State state;
  state.at = at;
  state.energy = energy;
  return state;
}

StateSpace space_of(const std::vector<Vec3>& positions, double spacing = h) {
  StateSpace space({.spacing = spacing});
  for (const Vec3& p : positions) space.insert(state_at(p));
  return space;
}

// The label by its definition: exact inequalities on brute-force measures. Only for generic positions.
Label label_of(const Coverage& c, double gamma_near_deg, double gamma_far_deg) {
  if (c.spread <= 0.95 * h && gamma_near_deg < 90) return Label::safe;
  if (c.delta <= 1.5 * h) return Label::sparse;
  return gamma_far_deg <= 85 ? Label::gap : Label::blank;
}

// gamma from all planes through three directions: a plane with all directions on one side is a facet of the
// hull.
double brute_gamma_deg(const std::vector<Vec3>& states, const Vec3& q, double radius) {
  std::vector<Vec3> u;
  for (const Vec3& p : states)
    if ((p - q).norm() <= radius && (p - q).norm() > 1e-9 * h) u.push_back((p - q).normalized());
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < u.size(); ++i)
    for (std::size_t j = i + 1; j < u.size(); ++j)
      for (std::size_t k = j + 1; k < u.size(); ++k) {
        Vec3 n = (u[j] - u[i]).cross(u[k] - u[i]);
        if (n.norm() < 1e-12) continue;
        n.normalize();
        double top = -2, bottom = 2;
        for (const Vec3& v : u) top = std::max(top, n.dot(v)), bottom = std::min(bottom, n.dot(v));
        const double offset = n.dot(u[i]);
        if (top <= offset + 1e-12) lowest = std::min(lowest, offset);
        if (bottom >= offset - 1e-12) lowest = std::min(lowest, -offset);
      }
  if (lowest > 0 && lowest <= 1) return std::acos(lowest) * 180 / std::numbers::pi;
  return 180;  // not enclosed: the exact angle is not needed
}

std::vector<Vec3> random_set(std::mt19937_64& random, int kind, std::size_t n) {
  std::uniform_real_distribution<double> uniform(-2.5 * h, 2.5 * h);
  std::uniform_int_distribution<int> cell(-2, 2);
  std::vector<Vec3> set;
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 p(uniform(random), uniform(random), uniform(random));
    if (kind == 1) p = h * Vec3(cell(random), cell(random), cell(random));             // lattice
    if (kind == 2) p = h * Vec3(cell(random), cell(random), cell(random)) + 1e-4 * p;  // jittered lattice
    if (kind == 3) p.z() = i < n / 2 ? 0.0 : p.z();                                    // a sheet and more
    if (kind == 4)
      p = i % 2 ? Vec3(0.5 * h * std::round(p.x() / (0.5 * h)), p.y(), p.z()) : p;  // near cell faces
    set.push_back(p);
  }
  return set;
}

Vec3 random_query(std::mt19937_64& random, const std::vector<Vec3>& set) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::uniform_int_distribution<std::size_t> pick(0, set.size() - 1);
  const Vec3 far = 4 * h * Vec3(uniform(random), uniform(random), uniform(random));
  switch (std::uniform_int_distribution<int>(0, 4)(random)) {
    case 0:
      return set[pick(random)];  // at a state
    case 1:
      return 0.5 * (set[pick(random)] + set[pick(random)]);  // on an edge of something
    case 2:
      return (set[pick(random)] + set[pick(random)] + set[pick(random)]) / 3;
    case 3:
      return set[pick(random)] + 1e-7 * far;
    default:
      return far;
  }
}

int rank(Label label) {
  return static_cast<int>(label);
}

}  // namespace

TEST_CASE("labels along a line out of a slab match the known numbers") {
  const auto runs = [](const StateSpace& space, int last) {
    std::vector<std::pair<int, Label>> result;
    for (int mm = 0; mm <= last; ++mm) {
      const Label label = space.coverage({mm * 1e-3, 0.0017, 0.0023}).label;
      REQUIRE(space.label({mm * 1e-3, 0.0017, 0.0023}) == label);
      if (result.empty() || result.back().second != label) result.emplace_back(mm, label);
    }
    return result;
  };
  using Runs = std::vector<std::pair<int, Label>>;
  CHECK(runs(space_of(make_setup("gap").states), 60) ==
        Runs{{0, Label::safe}, {1, Label::sparse}, {9, Label::gap}, {40, Label::sparse}, {48, Label::safe}});
  CHECK(runs(space_of(make_setup("blank").states), 40) ==
        Runs{{0, Label::safe}, {1, Label::sparse}, {9, Label::blank}});
  const StateSpace wide = space_of(make_setup("gap", {.width = 0.120}).states);
  CHECK(wide.coverage({0.060, 0.0017, 0.0023}).label == Label::blank);
  CHECK(wide.coverage({0.112, 0.0017, 0.0023}).label == Label::sparse);
}

TEST_CASE("a full lattice has spread sqrt(3)/2 h at its cell centres and is safe throughout") {
  const StateSpace space = space_of(make_setup("full", {.depth = 3, .half_width = 3, .width = 0.018}).states);
  const Coverage middle = space.coverage({0.5 * h, 0.5 * h, 0.5 * h});
  CHECK(middle.spread == Approx(std::sqrt(3.0) / 2 * h).epsilon(1e-12));
  CHECK(middle.alpha == Approx(std::sqrt(3.0) / 2 * h).epsilon(1e-12));
  CHECK(middle.delta == Approx(std::sqrt(3.0) / 2 * h).epsilon(1e-12));
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-0.017, 0.017);
  for (int i = 0; i < 2000; ++i)
    REQUIRE(space.label({uniform(random), uniform(random), uniform(random)}) == Label::safe);
}

TEST_CASE("named places have the labels of the definitions") {
  std::vector<Vec3> lattice27;
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (int k = -3; k <= 3; ++k) lattice27.push_back(h * Vec3(i, j, k));
  const auto without = [&](auto&& gone) {
    std::vector<Vec3> kept;
    for (const Vec3& p : lattice27)
      if (!gone(static_cast<int>(std::lround(p.x() / h)), static_cast<int>(std::lround(p.y() / h)),
                static_cast<int>(std::lround(p.z() / h))))
        kept.push_back(p);
    return space_of(kept);
  };
  SECTION("around the place of one missing state it is sparse, with spread h there") {
    const StateSpace space = without([](int i, int j, int k) { return i == 0 && j == 0 && k == 0; });
    const Coverage here = space.coverage(Vec3::Zero());
    CHECK(here.label == Label::sparse);
    CHECK(here.spread == Approx(h));
    CHECK(space.label({0.4 * h, 0.1 * h, 0.1 * h}) == Label::safe);  // pi^2 = h^2 (1 - 0.18)
  }
  SECTION("one missing layer is sparse between its neighbours") {
    const StateSpace space = without([](int, int, int k) { return k == 0; });
    CHECK(space.label({0.3 * h, 0.2 * h, 0}) == Label::sparse);
    CHECK(space.label({0.3 * h, 0.2 * h, 1.4 * h}) == Label::safe);
  }
  SECTION("a 3 x 3 x 3 hole is a gap at its centre") {
    const StateSpace space = without([](int i, int j, int k) {
      return std::max({std::abs(i), std::abs(j), std::abs(k)}) <= 1;
    });
    const Coverage here = space.coverage(Vec3::Zero());
    CHECK(here.label == Label::gap);
    CHECK(here.delta == Approx(2 * h));
    CHECK(here.gamma_deg < 30);
  }
  SECTION("a concave corner of the known area is not safe, the known arms are") {
    const StateSpace space = without([](int i, int j, int k) { return i > 0 && j > 0 && k > 0; });
    CHECK(space.label({-0.5 * h, 0.4 * h, 0.3 * h}) == Label::safe);
    CHECK(space.label({0.9 * h, 0.9 * h, 0.9 * h}) == Label::sparse);
    CHECK(space.label({2.6 * h, 2.6 * h, 2.6 * h}) == Label::blank);
  }
}

TEST_CASE("degenerate sets are never safe") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-2 * h, 2 * h);
  SECTION("no state") {
    const StateSpace space = space_of({});
    const Coverage none = space.coverage({0.1, 0, 0});
    CHECK(none.label == Label::blank);
    CHECK(std::isinf(none.delta));
    CHECK(std::isnan(none.gamma_deg));
    CHECK(space.delaunay().dimension() == -1);
  }
  SECTION("one to three states") {
    for (std::size_t n = 1; n <= 3; ++n) {
      std::vector<Vec3> set;
      for (std::size_t i = 0; i < n; ++i) set.emplace_back(uniform(random), uniform(random), uniform(random));
      const StateSpace space = space_of(set);
      CHECK(space.coverage(set[0]).label == Label::sparse);
      CHECK(space.coverage(set[0]).delta == 0);
      CHECK(std::isinf(space.coverage(set[0]).spread));
      for (int i = 0; i < 500; ++i)
        REQUIRE(space.label(4 * Vec3(uniform(random), uniform(random), uniform(random))) != Label::safe);
    }
  }
  SECTION("a lone state is sparse to 1.5 h, then blank") {
    const StateSpace space = space_of({Vec3(0.01, 0.02, 0.03)});
    CHECK(space.label(Vec3(0.01 + 1.49 * h, 0.02, 0.03)) == Label::sparse);
    CHECK(space.label(Vec3(0.01 + 1.51 * h, 0.02, 0.03)) == Label::blank);
    CHECK(space.coverage(Vec3(0.01 + 2 * h, 0.02, 0.03)).gamma_deg == Approx(180));
  }
  SECTION("collinear rows and coplanar sheets, along the axes and oblique") {
    for (const bool oblique : {false, true}) {
      const Mat3 turn =
          oblique ? Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix() : Mat3::Identity();
      for (const int sheet : {0, 1}) {
        std::vector<Vec3> set;
        for (int i = -4; i <= 4; ++i)
          for (int j = -4 * sheet; j <= 4 * sheet; ++j) set.push_back(turn * (0.5 * h * Vec3(i, j, 0)));
        const StateSpace space = space_of(set);
        for (const Vec3& p : set) REQUIRE(space.coverage(p).label == Label::sparse);
        for (int i = 0; i < 500; ++i) {
          const Vec3 q(uniform(random), uniform(random), i % 2 ? 0.0 : uniform(random));
          REQUIRE(space.label(turn * q) != Label::safe);
          REQUIRE(space.coverage(turn * q).label == space.label(turn * q));
        }
      }
    }
  }
}

TEST_CASE("labels follow brute-force measures on small sets") {
  std::size_t compared = 0;
  for (const std::uint64_t seed : {11u, 12u, 13u}) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-4 * h, 4 * h);
    for (int round = 0; round < 40; ++round) {
      const std::vector<Vec3> set = random_set(random, round % 5, 8 + static_cast<std::size_t>(round) % 17);
      const StateSpace space = space_of(set);
      for (int i = 0; i < 20; ++i) {
        const Vec3 q(uniform(random), uniform(random), uniform(random));
        const Coverage c = space.coverage(q);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& p : set) nearest = std::min(nearest, (p - q).norm());
        REQUIRE(c.delta == Approx(nearest).epsilon(1e-12));
        const double near = brute_gamma_deg(set, q, 1.45 * h), far = brute_gamma_deg(set, q, 8 * h);
        if (std::abs(far - 85) < 1e-4 || std::abs(near - 90) < 1e-3) continue;
        REQUIRE(c.label == label_of(c, near, far));
        REQUIRE(space.label(q) == c.label);
        if (!std::isnan(c.gamma_deg) && far < 90) REQUIRE(c.gamma_deg == Approx(far).epsilon(1e-7));
        if (far < 90) REQUIRE(std::isfinite(c.spread));
        ++compared;
      }
    }
  }
  CHECK(compared > 2000);
}

TEST_CASE("adding a state never worsens a label, a spread or a distance") {
  std::size_t checks = 0;
  for (const std::uint64_t seed : {21u, 22u, 23u, 24u}) {
    std::mt19937_64 random(seed);
    for (int round = 0; round < 25; ++round) {
      const std::vector<Vec3> set = random_set(random, round % 5, 40);
      std::vector<Vec3> queries;
      for (int i = 0; i < 12; ++i) queries.push_back(random_query(random, set));
      StateSpace space({.spacing = h});
      std::vector<Coverage> before(queries.size());
      for (const Vec3& p : set) {
        space.insert(state_at(p));
        for (std::size_t i = 0; i < queries.size(); ++i) {
          const Coverage now = space.coverage(queries[i]);
          REQUIRE(rank(now.label) <= rank(before[i].label));
          REQUIRE(rank(space.label(queries[i])) == rank(now.label));
          REQUIRE((now.spread <= before[i].spread * (1 + 1e-9) + 1e-12 || std::isinf(before[i].spread)));
          REQUIRE((now.delta <= before[i].delta));
          before[i] = now;
          ++checks;
        }
      }
    }
  }
  CHECK(checks > 40000);
}

TEST_CASE("translation, scaling, order of insertion and duplicates change no label") {
  std::size_t checks = 0;
  for (const std::uint64_t seed : {31u, 32u, 33u}) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int round = 0; round < 30; ++round) {
      std::vector<Vec3> set = random_set(random, round % 5, 60);
      std::vector<Vec3> queries;
      for (int i = 0; i < 30; ++i) queries.push_back(random_query(random, set));
      const Vec3 shift(uniform(random), uniform(random), uniform(random));
      const double scale = std::exp(3 * uniform(random));
      std::vector<Vec3> shifted, scaled, shuffled = set, doubled = set;
      for (const Vec3& p : set) {
        shifted.push_back(p + shift);
        scaled.push_back(scale * p);
        doubled.push_back(p);
        doubled.push_back(p + Vec3::Constant(1e-10 * h));
      }
      std::shuffle(shuffled.begin(), shuffled.end(), random);
      const StateSpace base = space_of(set), a = space_of(shifted), b = space_of(scaled, scale * h),
                       c = space_of(shuffled), d = space_of(doubled);
      REQUIRE(d.size() == base.size());
      for (const Vec3& q : queries) {
        const Label label = base.coverage(q).label;
        REQUIRE(a.coverage(q + shift).label == label);
        REQUIRE(b.coverage(scale * q).label == label);
        REQUIRE(c.coverage(q).label == label);
        REQUIRE(d.coverage(q).label == label);
        ++checks;
      }
    }
  }
  CHECK(checks > 2000);
}

TEST_CASE("a duplicate keeps the state already there") {
  StateSpace space({.spacing = h});
  const auto first = space.insert(state_at({0, 0, 0}, 1));
  const auto again = space.insert(state_at({0, 0, 5e-10 * h}, 2));
  CHECK(first.is_new);
  CHECK_FALSE(again.is_new);
  CHECK(again.id == first.id);
  CHECK(space[first.id].energy == 1);
  CHECK(space.find(Vec3(0, 0, 9e-10 * h)) == first.id);
  CHECK_FALSE(space.find(Vec3(0, 0, 1e-6 * h)).valid());
}

TEST_CASE("nearest and within are exact, ties by id") {
  std::mt19937_64 random(41);
  for (int kind = 0; kind < 5; ++kind) {
    const StateSpace space = space_of(random_set(random, kind, 700));
    std::vector<StateId> found;
    for (int i = 0; i < 60; ++i) {
      std::vector<Vec3> all;
      for (std::uint32_t id = 0; id < space.size(); ++id) all.push_back(space[{id}].at);
      const Vec3 q = random_query(random, all);
      std::vector<std::pair<double, std::uint32_t>> sorted;
      for (std::uint32_t id = 0; id < space.size(); ++id)
        sorted.emplace_back((all[id] - q).squaredNorm(), id);
      std::sort(sorted.begin(), sorted.end());
      space.nearest(q, 30, found);
      REQUIRE(found.size() == std::min<std::size_t>(30, space.size()));
      for (std::size_t k = 0; k < found.size(); ++k) REQUIRE(found[k].value == sorted[k].second);
      space.within(q, 1.3 * h, found);
      const auto inside = static_cast<std::size_t>(std::count_if(
          sorted.begin(), sorted.end(), [&](const auto& s) { return s.first <= 1.3 * h * 1.3 * h; }));
      REQUIRE(found.size() == inside);
      for (std::size_t k = 0; k < found.size(); ++k) REQUIRE(found[k].value == sorted[k].second);
    }
  }
}

TEST_CASE("the lattice holds rest and its box, outward from rest") {
  const std::vector<Vec3> all = lattice({Vec3(-0.012, -0.006, -0.006), Vec3(0.006, 0.006, 0.007)}, h);
  CHECK(all.size() == 4 * 3 * 3);
  CHECK(all[0] == Vec3::Zero());
  for (std::size_t i = 1; i < all.size(); ++i) REQUIRE(all[i].norm() >= all[i - 1].norm() - 1e-12);
  CHECK(all[1] == Vec3(0, 0, -0.006));
}

TEST_CASE("impossible options are refused") {
  CHECK_THROWS_AS(StateSpace({.spacing = 0}), InputError);
  CHECK_THROWS_AS(StateSpace({.spacing = h, .coverage = {.sparse_distance = 0.5}}), InputError);
  CHECK_THROWS_AS(make_setup("mountain"), InputError);
}
