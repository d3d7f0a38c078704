// bench viscosity: curves against closed forms, and the command.

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "apps/bench/viscous_curves.hpp"
#include "tests/support/executable.hpp"

using namespace forefeel;
using test::beam_scene;
using test::Workshop;

namespace {

// f(s) = a s + b s^3: a cubic, so that Hermite polynomials are exact.
ElasticLine stiffening(double a, double b) {
  std::vector<State> states;
  for (int i = 0; i <= 4; ++i) {
    State state;
    const double s = 0.005 * i;
    state.at = Vec3(0, 0, -s);
    state.force = Vec3(0.1, 0, a * s + b * s * s * s);
    state.stiffness = (a + 3 * b * s * s) * Mat3::Identity();
    state.solve.status = SolveStatus::converged;
    states.push_back(state);
  }
  return {states, -Vec3::UnitZ()};
}

}  // namespace

TEST_CASE("the elastic line is that of its states, and its inverse finds the place of a force",
          "[bench_viscosity]") {
  const ElasticLine line = stiffening(100, 1e5);
  CHECK(line.depth() == Approx(0.02));
  for (const double s : {0.0, 0.003, 0.0101, 0.02}) {
    CHECK(line.force(s) == Approx(100 * s + 1e5 * s * s * s));
    CHECK(line.slope(s) == Approx(100 + 3e5 * s * s));
    CHECK(line.place(line.force(s)) == Approx(s).margin(1e-12));
  }
}

TEST_CASE("relaxation, creep and loops of one branch follow their closed forms", "[bench_viscosity]") {
  constexpr double g = 0.4, tau = 0.2, k = 100;
  const Viscosity one{{g, tau}};
  const ElasticLine line = stiffening(k, 0);
  const ViscousCurve relaxation = relaxation_curve(line, one, 1e-3, 100);
  CHECK(relaxation.x.front() == 0);
  CHECK(relaxation.exact.front() == Approx(k * 0.02));
  CHECK(relaxation.exact.back() == Approx((1 - g) * k * 0.02).epsilon(0.01));
  CHECK(relaxation.largest() < 1e-12);

  // Standard linear solid: J(t) = 1 / (1 - g) - g / (1 - g) exp(-(1 - g) t / tau).
  const ViscousCurve creep = creep_curve(line, one, 0.9, 1e-3, 100);
  for (std::size_t i = 0; i < creep.x.size(); ++i) {
    const double compliance = 1 / (1 - g) - g / (1 - g) * std::exp(-(1 - g) * creep.x[i] / tau);
    CHECK(creep.exact[i] == Approx(0.9 / k * compliance).epsilon(1e-9));
  }
  CHECK(creep.largest() < 1e-5);

  // In a settled loop the loss modulus is g w tau / (1 + w^2 tau^2): the energy lost is pi k a^2 times that.
  constexpr double period = 2, a = 0.01, turn = 2 * M_PI / period * tau;
  const ViscousCurve loop = hysteresis_loop(line, one, period, 1e-3);
  CHECK(loop.x.size() == 2000);
  CHECK(loop.area(loop.exact) == Approx(M_PI * k * a * a * g * turn / (1 + turn * turn)).epsilon(1e-3));
  CHECK(loop.largest() < 1e-4);
  // The filter is of second order in the frame.
  const double coarse = hysteresis_loop(line, one, period, 4e-3).largest();
  CHECK(coarse / loop.largest() == Approx(16).epsilon(0.1));
}

TEST_CASE("bench viscosity draws what a viscous scene does, and refuses an elastic one",
          "[bench_viscosity]") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const std::string viscous = "--set 'material.viscosity=[{share=0.3,time=0.05},{share=0.2,time=0.4}]'";
  const Workshop::Outcome outcome = shop.forefeel("bench viscosity beam.toml " + viscous + " --json -o out");
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const nlohmann::json found = outcome.json();
  CHECK(found["relaxation"]["long_term_share"].get<double>() == Approx(0.5));
  CHECK(found["relaxation"]["error"].get<double>() < 1e-12);
  CHECK(found["creep"]["error"].get<double>() < 1e-3);
  CHECK(found["creep"]["to"].get<double>() > 1.5 * found["creep"]["from"].get<double>());
  REQUIRE(found["hysteresis"].size() == 3);
  for (const auto& loop : found["hysteresis"]) {
    CHECK(loop["error"].get<double>() < 1e-3);
    CHECK(loop["lost"].get<double>() > 0);
    CHECK(loop["lost"].get<double>() == Approx(loop["lost_exact"].get<double>()).epsilon(0.01));
  }
  CHECK(found["rows"][0]["ratio"].get<double>() > 0);
  CHECK_THAT(shop.files(), Catch::Contains("out/viscosity.csv"));
  check_refused(shop, "bench viscosity beam.toml", {"beam.toml", "no viscosity", "[[material.viscosity]]"});
}
