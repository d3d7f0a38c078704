// Solved states and jets of single places as corrections of the energy of sites: exact where they were made, with exact
// derivatives, without jumps, nothing for a linear body.
#include <Eigen/Geometry>

#include "pad_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/jet/deep_states.hpp"
#include "solver/jet/field_patches.hpp"
#include "tests/support/test.hpp"

namespace {

struct Deep {
  std::shared_ptr<const SiteField> field;
  std::vector<State> states;  // solved
  std::vector<State> rests;   // jets at rest of their sites
};

Vec3 deeply(const SiteField& field, const SurfacePlace& place, double depth, double aside) {
  const Vec3 n = field.rest().pad().normal(place);
  return depth * (-n + aside * n.unitOrthogonal());
}

State solved_at(const SiteField& field, const SurfacePlace& place, const Vec3& x, int jet = 1) {
  Body there = field.rest().body();
  there.pad->site = place.at;
  State state = Solver(std::move(there)).reference(x, 0.006, {.jet = jet}).state;
  state.site = place.at;
  return state;
}

State rest_at(SiteJets& jets, const SurfacePlace& place) {
  const RestJet made = jets.at(place);
  State state;
  state.site = place.at;
  state.force.setZero();
  state.energy = 0;
  state.stiffness = made.stiffness;
  state.jet = std::make_shared<const EnergyJet>(made.jet);
  state.solve.status = SolveStatus::converged;
  return state;
}

Deep deep_of(Law law, int jet = 1, int count = 4) {
  const auto body = padded_phantom("liver", 600, phantom_tip("liver"), law);
  const auto rest = std::make_shared<const RestSites>(body, 2);
  Deep deep{.field = std::make_shared<const SiteField>(rest, SiteFieldOptions{.spacing = 0.02}),
            .states = {},
            .rests = {}};
  SiteJets jets(*rest);
  const SurfacePlace first = rest->map().nearest(phantom_tip("liver"));
  for (int i = 0; i < count; ++i) {
    const Vec3 way = 0.004 * i * rest->map().facet(first).normal.unitOrthogonal();
    const SurfacePlace place = rest->map().walk(first, way).end;
    deep.states.push_back(
        solved_at(*deep.field, place, deeply(*deep.field, place, 0.018 + 0.001 * i, 0.1 * i), jet));
    deep.rests.push_back(rest_at(jets, place));
  }
  return deep;
}

std::shared_ptr<const DeepStates> all_of(const Deep& deep) {
  return DeepStates(deep.field).with(deep.rests)->with(deep.states);
}

double relative(const Vec3& force, const Vec3& right) {
  return (force - right).norm() / right.norm();
}

}  // namespace

TEST_CASE("At a state the force, the stiffness and the energy are its own") {
  for (const int jet : {1, 4}) {
    const Deep deep = deep_of(Law::neo_hookean, jet);
    const auto set = all_of(deep);
    REQUIRE(set->size() == 8);
    for (const State& state : deep.states) {
      const SurfacePlace place = deep.field->rest().map().nearest(state.site);
      const SiteModel model = deep.field->at(place, false);
      const SiteTerms at = set->at(model, place, state.at);
      CHECK(relative(at.force, state.force) < 1e-9);
      CHECK((at.stiffness - state.stiffness).norm() < 1e-8 * state.stiffness.norm());
      CHECK(std::abs(at.energy - state.energy) < 1e-9 * state.energy);
      CHECK(relative(model.at(state.at).force, state.force) > 1e-4);
      CHECK(set->estimated_error(model, place, state.at) < 0.01 * model.estimate(state.at));
      CHECK(set->trusted(model, place, state.at, 1e-3, 0.01));
    }
  }
}

TEST_CASE("At the site of a jet at rest the energy is the jet's") {
  const Deep deep = deep_of(Law::neo_hookean);
  const auto set = DeepStates(deep.field).with(deep.rests);
  for (const State& state : deep.rests) {
    const SurfacePlace place = deep.field->rest().map().nearest(state.site);
    const Vec3 x = deeply(*deep.field, place, 0.01, 0.2);
    const Vec3 own = -(state.stiffness * x + jet_terms(*state.jet, x).gradient);
    CHECK(relative(set->at(deep.field->at(place, false), place, x).force, own) < 1e-9);
  }
}

TEST_CASE("With corrections force, stiffness and the derivative by the site are those of the energy") {
  const Deep deep = deep_of(Law::neo_hookean);
  const auto set = all_of(deep);
  const SurfaceMap& map = deep.field->rest().map();
  for (int i = 0; i < 8; ++i) {
    const State& near = deep.states[static_cast<std::size_t>(i % 4)];
    const Vec3 aside = 0.002 * (1 + i) * map.facet(map.nearest(near.site)).normal.unitOrthogonal();
    const SurfacePlace place = map.walk(map.nearest(near.site), aside).end;
    const SiteModel model = deep.field->at(place, true);
    const Vec3 x = near.at + 0.003 * near.at.unitOrthogonal();
    const SiteTerms at = set->at(model, place, x);
    CHECK((at.force - model.at(x).force).norm() > 1e-6 * at.force.norm());
    const SiteTerms soft = set->at(model, place, x, false);
    CHECK((soft.force - at.force).norm() < 1e-12 * at.force.norm());
    CHECK((soft.by_site - at.by_site).norm() < 1e-12 * at.force.norm());
    CHECK(soft.energy == Approx(at.energy).epsilon(1e-12));
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const SiteTerms up = set->at(model, place, x + h * Vec3::Unit(k)),
                      down = set->at(model, place, x - h * Vec3::Unit(k));
      CHECK(std::abs(at.force[k] + (up.energy - down.energy) / (2 * h)) < 1e-6 * at.force.norm());
      CHECK((at.stiffness.col(k) + (up.force - down.force) / (2 * h)).norm() < 1e-5 * at.stiffness.norm());
    }
    CHECK((at.stiffness - at.stiffness.transpose()).norm() < 1e-12 * at.stiffness.norm());
    const auto [a, b, c] = map.corners(place.facet);
    for (const Vec3& side : {Vec3(b - a), Vec3(c - a)}) {
      const Vec3 way = side.normalized();
      SurfacePlace up = place, down = place;
      up.at += h * way, down.at -= h * way;
      const double slope = (set->at(deep.field->at(up, false), up, x).energy -
                            set->at(deep.field->at(down, false), down, x).energy) /
                           (2 * h);
      CHECK(std::abs(at.by_site.dot(way) - slope) < 1e-5 * at.force.norm());
    }
  }
}

TEST_CASE("Corrections have no jump over facets, edges and the ends of states") {
  const Deep deep = deep_of(Law::neo_hookean);
  const auto set = all_of(deep);
  const SurfaceMap& map = deep.field->rest().map();
  const auto correction = [&](const SurfacePlace& place, const Vec3& x) {
    const SiteModel model = deep.field->at(place, false);
    return Vec3(set->at(model, place, x).force - model.at(x).force);
  };
  const State& first = deep.states.front();
  const double scale = first.force.norm();
  const SurfacePlace start = map.nearest(first.site);
  for (int direction = 0; direction < 6; ++direction) {
    const Vec3 n = map.facet(start).normal, e = n.unitOrthogonal();
    const Vec3 way = std::cos(direction) * e + std::sin(direction) * n.cross(e);
    Vec3 before = correction(start, first.at);
    double most = 0;
    for (int i = 1; i <= 60; ++i) {  // 30 mm, so past the last state; then 1 um on from each of the places
      const SurfacePlace place = map.walk(start, 0.0005 * i * way).end;
      if (map.facet(place).clamped) break;
      const Vec3 here = correction(place, first.at),
                 next = correction(map.walk(start, (0.0005 * i + 1e-6) * way).end, first.at);
      most = std::max(most, (here - before).norm());
      CHECK((next - here).norm() < 1e-4 * scale);
      before = here;
    }
    CHECK(most < 0.1 * scale);
  }
  CHECK(correction(start, 1e-9 * first.at).norm() < 1e-12 * scale);
  CHECK(correction(start, Vec3::Zero()).norm() == 0);
}

TEST_CASE("Nothing changes for a linear body") {
  const Deep deep = deep_of(Law::linear);
  const auto set = all_of(deep);
  const State& state = deep.states.front();
  const SurfacePlace place =
      deep.field->rest()
          .map()
          .walk(deep.field->rest().map().nearest(state.site), Vec3(0.002, 0.001, 0.001))
          .end;
  const SiteModel model = deep.field->at(place, false);
  const Vec3 x = state.at + Vec3(0.002, -0.001, 0.001);
  CHECK(relative(set->at(model, place, x).force, model.at(x).force) < 1e-6);
}

TEST_CASE("Between states the error falls") {
  const Deep deep = deep_of(Law::neo_hookean);
  const auto set = all_of(deep);
  const SurfaceMap& map = deep.field->rest().map();
  double before = 0, after = 0;
  for (const State& near : deep.states) {
    const SurfacePlace place =
        map.walk(map.nearest(near.site), 0.002 * map.facet(map.nearest(near.site)).normal.unitOrthogonal())
            .end;
    const Vec3 x = 0.95 * near.at + 0.001 * near.at.unitOrthogonal();
    const State right = solved_at(*deep.field, place, x);
    const SiteModel model = deep.field->at(place, false);
    before += relative(model.at(x).force, right.force);
    after += relative(set->at(model, place, x).force, right.force);
  }
  CHECK(after < 0.4 * before);
}

TEST_CASE("Over patches, where a jet at rest was made, K is exact") {
  const Deep deep = deep_of(Law::linear, 4, 3);
  const auto patches = std::make_shared<const FieldPatches>(deep.field);
  const DeepStates none(deep.field, {}, patches);
  const auto known = none.with(deep.rests);
  REQUIRE(known->size() == deep.rests.size());
  double before = 0;
  for (const State& rest : deep.rests) {
    const SurfacePlace place = deep.field->rest().map().nearest(rest.site);
    const Vec3 x = deeply(*deep.field, place, 0.01, 0.3), exact = -rest.stiffness * x;
    before = std::max(before, (none.at(none.model(place), place, x).force - exact).norm() / exact.norm());
    const SiteTerms now = known->at(known->model(place), place, x);
    CHECK((now.force - exact).norm() < 1e-8 * exact.norm());
    CHECK((now.stiffness - rest.stiffness).norm() < 1e-8 * rest.stiffness.norm());
    CHECK(now.energy == Approx(0.5 * x.dot(rest.stiffness * x)).epsilon(1e-8));
  }
  CHECK(before > 1e-5);
  // States over patches are exact where their site has a jet.
  const Deep soft = deep_of(Law::neo_hookean, 4, 2);
  const auto both = DeepStates(soft.field, {}, std::make_shared<const FieldPatches>(soft.field))
                        .with(soft.rests)
                        ->with(soft.states);
  for (const State& state : soft.states) {
    const SurfacePlace place = soft.field->rest().map().nearest(state.site);
    const SiteTerms here = both->at(both->model(place), place, state.at);
    CHECK((here.force - state.force).norm() < 1e-5 * state.force.norm());
    CHECK((here.stiffness - state.stiffness).norm() < 1e-4 * state.stiffness.norm());
  }
}

TEST_CASE("A set over patches keeps how far it erred where states came, in its own estimate") {
  const Deep deep = deep_of(Law::neo_hookean, 4, 2);
  const auto patches = std::make_shared<const FieldPatches>(deep.field);
  CHECK(patches->error() > 0);
  CHECK(FieldPatches(deep.field, patches->values()).error() == patches->error());
  const DeepStates none(deep.field, {}, patches);
  const auto known = none.with(deep.states);
  REQUIRE(known->scores().size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const State& state = deep.states[k];
    const SurfacePlace place = deep.field->rest().map().nearest(state.site);
    const SiteModel model = none.model(place);
    const double error = (none.at(model, place, state.at).force - state.force).norm();
    CHECK(known->scores()[k] == Approx(error / none.estimated_error(model, place, state.at)).epsilon(1e-9));
  }
  CHECK(DeepStates(deep.field).with(deep.states)->scores().empty());
}

TEST_CASE("States beyond a fold do not spoil the places before it") {
  // St. Venant-Kirchhoff: pressed deep enough, the body buckles under the pad, which no series from rest sees.
  const Deep deep = deep_of(Law::st_venant_kirchhoff, 4, 1);
  std::mt19937_64 random(3);
  SurfacePlace place;
  std::shared_ptr<const DeepStates> known;
  double surprise = 0;
  for (int tries = 0; tries < 12 && !(surprise > 3); ++tries) {
    place = deep.field->rest().map().random(random);
    if (deep.field->rest().at(place, false).clamped_share > 0) continue;
    std::vector<State> states;
    for (const double depth : {0.016, 0.019, 0.022})
      if (State state = solved_at(*deep.field, place, deeply(*deep.field, place, depth, 0.05), 4);
          state.usable())
        states.push_back(std::move(state));
    known = DeepStates(deep.field).with(states);
    for (std::size_t k = 0; k < known->size(); ++k) surprise = std::max(surprise, known->surprise(k));
  }
  REQUIRE(surprise > 3);
  const SiteModel model = deep.field->at(place, false);
  for (const double depth : {0.003, 0.005, 0.007, 0.009}) {
    const Vec3 x = deeply(*deep.field, place, depth, 0.02);
    const State truth = solved_at(*deep.field, place, x);
    const double alone = (model.at(x).force - truth.force).norm(),
                 with = (known->at(model, place, x).force - truth.force).norm();
    INFO(depth << " " << alone << " " << with);
    CHECK(with <= alone + 0.005 * truth.force.norm());
  }
}

TEST_CASE("States that cannot serve are left out") {
  const Deep deep = deep_of(Law::neo_hookean, 1, 1);
  State failed = deep.states[0], measured = deep.states[0], lost = deep.states[0];
  failed.solve.status = SolveStatus::diverged;
  measured.energy = unknown;
  lost.site.setConstant(unknown);
  const std::vector<State> list{failed, measured, lost};
  CHECK(DeepStates(deep.field).with(list)->size() == 0);
}
