// Touching a body anywhere: where touches begin and end, sliding, and that closed paths gain no work.
#include <Eigen/Geometry>

#include "geometry/meshing/phantom.hpp"
#include "scheduling/touch/touch.hpp"
#include "scheduling/workers/state_solver.hpp"
#include "solver/body/pad.hpp"
#include "tests/support/test.hpp"

namespace {

struct Liver {
  std::shared_ptr<const SiteField> sites;
  std::shared_ptr<const SurfaceGrid> grid;
};

const Liver& made_liver() {
  static const Liver made = [] {
    auto body = std::make_shared<Body>();
    body->mesh = phantom("liver", 600);
    body->material = {Law::neo_hookean, 5000, 0.4};
    body->clamp = body->mesh.groups.at("clamp");
    body->pad = Pad{};
    const auto sites = std::make_shared<const SiteField>(std::make_shared<const RestSites>(body, 2),
                                                         SiteFieldOptions{.spacing = 0.02, .threads = 2});
    return Liver{sites, std::make_shared<const SurfaceGrid>(sites->rest().map())};
  }();
  return made;
}

const FieldOfSites& liver() {
  static const FieldOfSites field(made_liver().sites, made_liver().grid, 0.06);
  return field;
}

// The model of a session: patches of the facets, jets and states at the hand's places.
const FieldOfSites& session_model() {
  static const std::shared_ptr<const DeepStates> deep = [] {
    const Liver& made = made_liver();
    SiteSolver solver(made.sites->rest_shared(), 0.006, false);
    std::mt19937_64 random(31);
    std::vector<State> states;
    for (int i = 0; i < 40; ++i) {
      const SurfacePlace place = made.sites->rest().map().random(random);
      states.push_back(solver.solve(place, Vec3::Zero(), nullptr, {}).state);
      const Vec3 x = -0.014 * made.sites->rest().pad().normal(place);
      if (State state = solver.solve(place, x, nullptr, {}).state; state.usable())
        states.push_back(std::move(state));
    }
    return DeepStates(made.sites).with(states);
  }();
  static const FieldOfSites field = [] {
    FieldOfSites made(made_liver().sites, made_liver().grid, 0.06,
                      std::make_shared<const FieldPatches>(made_liver().sites));
    made.use(deep.get());
    return made;
  }();
  return field;
}

Vec3 normal_at(const SurfacePlace& place) {
  return liver().at(place, Vec3::Zero()).normal;
}

// Force over a way of the tip while the site stays, by Gauss's rule of five points.
double work_of(const TouchField& field, const SurfacePlace& site, const Vec3& from, const Vec3& to) {
  constexpr std::array<double, 5> at{0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                     0.953089922969332},
      weight{0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683, 0.118463442528095};
  double sum = 0;
  for (std::size_t i = 0; i < 5; ++i)
    sum += weight[i] * field.at(site, from + at[i] * (to - from) - site.at).at.force.dot(to - from);
  return sum;
}

struct Loop {
  double gained = 0;  // work of the body on the hand over the loop [J]
  double most = 0;    // largest stored energy [J]
  double lost = 0;
};

// The tip along these places, the first and last outside, in straight lines of `steps` frames.
Loop follow(const TouchField& field, const std::vector<Vec3>& places, int steps,
            std::optional<double> friction) {
  Loop loop;
  Touch now;
  Vec3 last = places.front();
  for (std::size_t leg = 0; leg + 1 < places.size(); ++leg)
    for (int i = 1; i <= steps; ++i) {
      const Vec3 tip = places[leg] + (places[leg + 1] - places[leg]) * i / steps;
      const TouchFrame frame = touch(field, now, tip, friction);
      if (now.kind != TouchKind::none)
        loop.gained += work_of(field, now.site, last, frame.left.value_or(tip));
      if (frame.began) loop.gained += work_of(field, *frame.began, frame.began->at, tip);
      loop.most = std::max(loop.most, frame.energy);
      loop.lost += frame.lost;
      CHECK(frame.lost >= 0);
      now = frame.touch, last = tip;
    }
  CHECK(now.kind == TouchKind::none);
  return loop;
}

SurfacePlace place_near_tip() {
  return liver().map().nearest(phantom_tip("liver"));
}

}  // namespace

TEST_CASE("A touch begins where the tip crosses the surface, sticks when bonded, and ends outside") {
  const SurfacePlace place = place_near_tip();
  const Vec3 n = liver().map().facet(place).normal;
  Touch now = touch(liver(), {}, place.at + 0.002 * n, {}).touch;
  CHECK(now.kind == TouchKind::none);
  TouchFrame frame = touch(liver(), now, place.at - 0.004 * n, {});
  REQUIRE(frame.touch.kind == TouchKind::stick);
  CHECK((frame.touch.site.at - place.at).norm() < 1e-9);
  CHECK(frame.force.dot(n) > 0);
  frame = touch(liver(), frame.touch, place.at - 0.006 * n + 0.003 * n.unitOrthogonal(), {});
  CHECK(frame.touch.kind == TouchKind::stick);
  CHECK((frame.touch.site.at - place.at).norm() < 1e-9);
  const double stored = frame.energy;
  frame = touch(liver(), frame.touch, place.at + 0.001 * n, {});
  CHECK(frame.touch.kind == TouchKind::none);
  CHECK(frame.force.norm() == 0);
  CHECK(frame.lost < stored);
}

TEST_CASE("A tip that is inside from the start begins at the nearest place") {
  const SurfacePlace place = place_near_tip();
  const Vec3 tip = place.at - 0.003 * liver().map().facet(place).normal;
  const TouchFrame frame = touch(liver(), {}, tip, 0.3);
  REQUIRE(frame.began);
  CHECK((frame.began->at - liver().map().nearest(tip).at).norm() < 1e-12);
}

TEST_CASE("No touch begins through a clamped facet") {
  const SurfaceMap& map = liver().map();
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    if (!map.facets()[f].clamped) continue;
    const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
    const Vec3 middle = (a + b + c) / 3, n = map.facets()[f].normal;
    const Touch outside = touch(liver(), {}, middle + 0.001 * n, {}).touch;
    if (outside.inside) continue;
    CHECK(touch(liver(), outside, middle - 0.001 * n, {}).touch.kind == TouchKind::none);
    return;
  }
  FAIL("no clamped facet");
}

TEST_CASE("While a site slides, its drive is mu times the normal force, and energy is only lost") {
  std::mt19937_64 random(8);
  int slips = 0, rims = 0;
  for (int i = 0; i < 40; ++i) {
    const SurfacePlace place = liver().map().random(random);
    const Vec3 n = normal_at(place);
    const double friction = 0.1 + 0.02 * i;
    const Vec3 tip = place.at - 0.006 * n + 0.006 * n.unitOrthogonal();
    const TouchTerms before = liver().at(place, tip - place.at);
    const Slip slip = slide(liver(), place, tip, friction);
    const TouchTerms after = liver().at(slip.site, tip - slip.site.at);
    CHECK(slip.lost >= 0);
    CHECK(before.at.energy - after.at.energy == Approx(slip.lost).margin(1e-15));
    if (slip.slid == 0 || slip.end != SlipEnd::sticks) continue;
    ++slips;
    const double limit = friction * after.at.force.dot(after.normal);
    const double ratio = drive(after).norm() / limit;
    const bool on_edge = liver().map().barycentric(slip.site).minCoeff() < 1e-4;
    if (on_edge && ratio > 1.001)
      ++rims;  // both sides push to a kept edge
    else
      CHECK(std::abs(ratio - 1) < 1e-3);
  }
  CHECK(slips > 15);
  CHECK(rims <= 2);
}

namespace {

void check_loops(const TouchField& field) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> share(0, 1);
  double largest = 0, worst = 0;
  int slid = 0;
  for (int i = 0; i < 100; ++i) {
    const SurfacePlace place = field.map().random(random);
    const Vec3 n = field.at(place, Vec3::Zero()).normal, e = n.unitOrthogonal(), b = n.cross(e);
    const auto at = [&](double depth, double far) {
      return Vec3(place.at - depth * n + far * (2 * share(random) - 1) * e +
                  far * (2 * share(random) - 1) * b);
    };
    const Vec3 outside = place.at + 0.25 * n;
    std::optional<double> friction;
    if (i % 4 != 0) friction = 0.05 + share(random);
    const Loop loop = follow(field,
                             {outside, place.at + 0.001 * n, at(0.008, 0.002), at(0.008, 0.015),
                              at(0.006, 0.015), at(0.01, 0.01), outside},
                             12, friction);
    largest = std::max(largest, loop.most);
    worst = std::max(worst, loop.gained / std::max(loop.most, 1e-12));
    slid += loop.lost > 0;
    CHECK(loop.gained <= 1e-6 * loop.most + 1e-14);
    CHECK(std::abs(loop.gained + loop.lost) <=
          1e-5 * loop.most + 1e-14);  // what is lost is what the hand gave
  }
  INFO("worst " << worst);
  CHECK(largest > 1e-4);
  CHECK(slid > 50);
}

}  // namespace

TEST_CASE("Over closed paths of press, slide and lift the hand gains no work") {
  check_loops(liver());
}

TEST_CASE("Over closed paths the model of a session gains no work either") {
  REQUIRE(session_model().at(place_near_tip(), Vec3::Zero()).at.energy == Approx(0).margin(1e-12));
  check_loops(session_model());
}

namespace {

// A ball as a session has it, and a hand that slides around it.
struct Ball {
  static constexpr double radius = 0.05, height = 0.4, step = 6e-5;  // 60 mm/s at 1 kHz
  std::shared_ptr<const SiteField> sites;
  std::shared_ptr<const FieldOfSites> field;

  static Vec3 tip(double r, double way) {
    const double across = std::sqrt(1 - height * height), angle = way / (radius * across);
    return Vec3(r * across * std::cos(angle), r * across * std::sin(angle), r * height);
  }
  Touch pressed(double depth, double friction) const {
    Touch now;
    for (int i = 0; i < 200; ++i)
      now = touch(*field, now, tip(radius + 0.001 - (depth + 0.001) * i / 199, 0), friction).touch;
    return now;
  }
};

const Ball& ball() {
  static const Ball made = [] {
    auto body = std::make_shared<Body>();
    body->mesh = phantom("ball", 800);
    body->material = {Law::neo_hookean, 5000, 0.4};
    body->clamp = body->mesh.groups.at("clamp");
    body->pad = Pad{};
    Ball ball;
    ball.sites = std::make_shared<const SiteField>(std::make_shared<const RestSites>(body, 2),
                                                   SiteFieldOptions{.spacing = 0.015, .threads = 2});
    ball.field = std::make_shared<const FieldOfSites>(
        ball.sites, std::make_shared<const SurfaceGrid>(ball.sites->rest().map()), 0.06,
        std::make_shared<const FieldPatches>(ball.sites));
    return ball;
  }();
  return made;
}

double off_cone(const TouchFrame& frame, double friction) {
  const double limit = friction * frame.force.dot(frame.normal);
  return std::abs(frame.drive.norm() - limit) / (limit > 0 ? limit : frame.force.norm());
}

}  // namespace

TEST_CASE("A tip that slides around a ball feels no facet") {
  const FieldOfSites& field = *ball().field;
  CHECK(field.map().smooth().farthest() > 5e-4);  // of the facets
  constexpr double depth = 0.008, step = Ball::step;
  for (const double friction : {0.0, 0.1, 0.3}) {
    Touch now = ball().pressed(depth, friction);
    double largest = 0, farthest = 0, cone = 0, mean = 0;
    int slips = 0;
    for (int i = 1; i < 3000; ++i) {
      const TouchFrame frame = touch(field, now, Ball::tip(Ball::radius - depth, step * i), friction);
      REQUIRE(frame.touch.kind != TouchKind::none);
      CHECK_FALSE(frame.snaps);
      largest = std::max(largest, (frame.force - now.force).norm() / frame.force.norm());
      farthest = std::max(farthest, (frame.touch.site.at - now.site.at).norm());
      mean += frame.force.norm() / 3000;
      if (frame.touch.kind == TouchKind::slip) {
        ++slips;
        cone = std::max(cone, off_cone(frame, friction));
      }
      now = frame.touch;
    }
    INFO("friction " << friction << " largest " << largest << " farthest " << farthest);
    CHECK(slips > 2000);
    CHECK(mean > 0.5);
    CHECK(largest < 0.007);
    CHECK(farthest < 3 * step);
    CHECK(cone < 1e-3);
  }
}

TEST_CASE("A fast hand on a ball finds the site that a slow one finds") {
  const FieldOfSites& field = *ball().field;
  constexpr double depth = 0.010, friction = 0.3;
  constexpr int ratio = 10;  // 0.6 m/s
  Touch slow = ball().pressed(depth, friction), fast = slow;
  int slips = 0, limited = 0, limited_slowly = 0;
  double cone = 0, apart = 0, force = 0;
  for (int i = 1; i <= 4000; ++i) {
    const Vec3 tip = Ball::tip(Ball::radius - depth, Ball::step * i);
    const TouchFrame slowly = touch(field, slow, tip, friction);
    slow = slowly.touch, limited_slowly += slowly.snaps;
    if (i % ratio != 0) continue;
    const TouchFrame frame = touch(field, fast, tip, friction);
    CHECK(frame.lost >= 0);
    CHECK(frame.energy + frame.lost ==
          Approx(field.at(fast.site, tip - fast.site.at).at.energy).epsilon(1e-12));
    limited += frame.snaps;
    if (frame.touch.kind == TouchKind::slip) ++slips, cone = std::max(cone, off_cone(frame, friction));
    apart = std::max(apart, (frame.touch.site.at - slow.site.at).norm());
    force = std::max(force, (frame.force - slowly.force).norm() / slowly.force.norm());
    fast = frame.touch;
  }
  INFO("cone " << cone << " apart " << apart << " force " << force << " limited " << limited << " slowly "
               << limited_slowly);
  CHECK(slips > 300);
  CHECK(limited_slowly == 0);
  CHECK(limited == 0);
  CHECK(cone < 1e-3);
  CHECK(apart < 1e-4);
  CHECK(force < 0.006);
}

namespace {

// Springs to a tip over a slab, and wells along x: with A q^2 above k the site hangs in a well, and then snaps.
//   E = k |x|^2 / 2 + A (1 - cos(q s_x))
class Wells final : public TouchField {
 public:
  static constexpr double k = 200, wave = 400, energy = 0.01;
  explicit Wells(const SurfaceMap& map) : map_(map), grid_(map) {}
  using TouchField::at;
  TouchTerms at(const SurfacePlace& site, const Vec3& x, bool) const override {
    TouchTerms terms;
    const double phase = wave * site.at.x();
    terms.at.energy = 0.5 * k * x.squaredNorm() + energy * (1 - std::cos(phase));
    terms.at.force = -k * x;
    terms.at.stiffness = k * Mat3::Identity();
    terms.at.by_site = energy * wave * std::sin(phase) * Vec3::UnitX();
    terms.normal = terms.across = map_.on_facet(site).normal;
    return terms;
  }
  const SurfaceMap& map() const override { return map_; }
  const SurfaceGrid& grid() const override { return grid_; }

 private:
  const SurfaceMap& map_;
  SurfaceGrid grid_;
};

}  // namespace

TEST_CASE("Where the body snaps, the force changes by the switch's bound a frame, and energy is only lost") {
  Body slab;
  slab.mesh = phantom("slab", 600);
  const SurfaceMap map(slab);
  const Wells field(map);
  const Vec3 start(-0.02, 0.001, 0.04);
  Touch now = touch(field, {}, start + Vec3(0, 0, 0.001), 0.0).touch;
  for (int i = 1; i <= 100; ++i) now = touch(field, now, start - Vec3(0, 0, 1e-4 * i), 0.0).touch;
  REQUIRE(now.kind != TouchKind::none);
  int snaps = 0;
  double lost = 0, given = 0, energy = field.at(now.site, now.tip - now.site.at).at.energy;
  const auto follow = [&](const Vec3& tip) {
    const TouchFrame frame = touch(field, now, tip, 0.0);
    const double moved = (tip - now.tip).norm();
    const Vec3 held = field.at(now.site, tip - now.site.at).at.force;
    const double change = (frame.force - now.force).norm(), motion = (held - now.force).norm();
    CHECK(change <= motion + std::max(0.007 * now.force.norm(), 1e-3) + 1e-12);
    CHECK((frame.touch.site.at - now.site.at).norm() <= std::max(3 * moved, 1e-4) + 1e-9);
    CHECK(frame.lost >= 0);
    given += field.at(now.site, tip - now.site.at).at.energy - energy;  // by the hand, at a site that stays
    energy = frame.energy, lost += frame.lost;
    snaps += frame.snaps;
    now = frame.touch;
  };
  const double first = energy;
  const Vec3 pressed = now.tip;
  for (int i = 1; i <= 800; ++i) follow(pressed + Vec3(5e-5 * i, 0, 0));
  CHECK(snaps > 10);
  CHECK(lost > 1e-4);
  for (int i = 0; i < 400; ++i) follow(now.tip);  // at rest: the site goes on to where it stays
  CHECK(drive(field.at(now.site, now.tip - now.site.at)).norm() < 1e-3 * now.force.norm());
  CHECK(first + given == Approx(energy + lost).epsilon(1e-9));
}
