#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "block_body.hpp"
#include "solver/body/refined_body.hpp"
#include "solver/equilibrium/mesh_study.hpp"
#include "sphere_shell.hpp"

using namespace forefeel;

namespace {

MeshStudyRow row(std::size_t elements, Element element, double force) {
  return {.elements = elements, .element = element, .nodes = 1, .force = force, .work = double(elements)};
}

double size_of(std::size_t elements) {
  return std::cbrt(1 / static_cast<double>(elements));
}

}  // namespace

TEST_CASE("the extrapolation finds the limit and the rates of forces that follow its law") {
  std::vector<MeshStudyRow> rows;
  for (const std::size_t n : {250, 500, 1000, 2000, 4000, 8000}) {
    rows.push_back(row(n, Element::linear, 2 + 3 * std::pow(size_of(n), 1.7)));
    if (n < 4000) rows.push_back(row(n, Element::quadratic, 2 + 9 * std::pow(size_of(n), 3.1)));
  }
  const MeshLimit limit = extrapolated(rows);
  CHECK(limit.force == Approx(2).epsilon(1e-8));
  CHECK(limit.rate[0] == Approx(1.7));
  CHECK(limit.rate[1] == Approx(3.1));
  compare(rows, limit);
  for (const MeshStudyRow& r : rows) CHECK(r.error == Approx(std::abs(r.force - 2) / 2).epsilon(1e-6));
  const auto best = cheapest(rows, 0.02);
  REQUIRE(best);
  for (const MeshStudyRow& r : rows)
    if (r.error <= 0.02) CHECK(rows[*best].work <= r.work);
  CHECK(rows[*best].error <= 0.02);
  CHECK_FALSE(cheapest(rows, 1e-9));
}

TEST_CASE("one mesh of a kind says nothing, failed solves are left out") {
  CHECK_FALSE(extrapolated(std::array{row(1000, Element::linear, 2.0)}).known());
  CHECK_FALSE(extrapolated({}).known());
  std::vector<MeshStudyRow> rows{row(1000, Element::linear, 2.0), row(8000, Element::linear, 1.9),
                                 row(1000, Element::quadratic, unknown)};
  const MeshLimit limit = extrapolated(rows);
  const double gain = std::pow(2, 1.2);  // of halving the size, at the rate that is taken for granted
  CHECK(limit.force == Approx((gain * 1.9 - 2.0) / (gain - 1)).epsilon(1e-9));
  compare(rows, limit);
  CHECK(std::isnan(rows[2].error));
  rows.push_back(row(2000, Element::linear, 5.0));  // with a contact of its own
  rows.back().remeshed = true;
  CHECK(extrapolated(rows).force == limit.force);
}

TEST_CASE("a bent block: the limit of coarse meshes is near the force of a much finer one") {
  // A beam that is clamped and pushed at all of its end, so that nothing is singular but the clamp's edge.
  const auto body = [](int refine) {
    auto made = block_body(Law::linear, 0.3, refine);
    made->contact.clear();
    for (std::size_t i = 0; i < made->mesh.nodes.size(); ++i)
      if (made->mesh.nodes[i][0] > 0.1 - 1e-9) made->contact.push_back(static_cast<NodeIndex>(i));
    return made;
  };
  const Vec3 x(0, 0.004, 0);
  std::vector<MeshStudyRow> rows;
  for (const int refine : {1, 2, 3})
    for (const Element element : {Element::linear, Element::quadratic}) {
      auto made = body(refine);
      made->element = element;
      rows.push_back(study_row(made, x));
      CHECK(rows.back().elements == made->mesh.tets.size());
      CHECK(rows.back().work > 0);
    }
  const MeshLimit limit = extrapolated(rows);
  auto fine = body(6);
  fine->element = Element::quadratic;
  const double truth = study_row(fine, x).force;
  CAPTURE(limit.force, truth, limit.rate[0], limit.rate[1]);
  CHECK(limit.force == Approx(truth).epsilon(0.003));
  CHECK(rows[0].force > 1.1 * truth);  // which the coarse meshes are far from
  CHECK(limit.rate[0] > 1.2);          // of linear elements: 2, less what the clamp's edge costs
}

TEST_CASE("a body between two spheres: rate 2 towards the exact stiffness, within the uncertainty") {
  const Material material{Law::neo_hookean, 5e3, 0.3};
  const double a = 0.04, b = 0.06, exact = 1e-3 * shell_stiffness(a, b, material.young, material.poisson);
  const Vec3 x(0, 0.6e-3, 0.8e-3);
  std::vector<MeshStudyRow> rows;
  for (const int times : {1, 2, 3, 4})
    rows.push_back(study_row(sphere_shell(times, 1 << (times - 1), a, b, material), x));
  const auto error = [&](std::size_t i) { return std::abs(rows[i].force - exact) / exact; };
  const double rate = std::log2(error(2) / error(3));
  CAPTURE(exact, rows[1].force, rows[2].force, rows[3].force, rate);
  CHECK(error(3) < 0.003);
  CHECK(rate > 1.85);
  CHECK(rate < 2.15);
  const MeshLimit limit = extrapolated(rows);
  CAPTURE(limit.force, limit.uncertainty, limit.rate[0]);
  CHECK(limit.rate[0] > 1.6);
  CHECK(limit.rate[0] < 2.15);
  CHECK(std::abs(limit.force - exact) < limit.uncertainty * exact);
  CHECK(limit.uncertainty < 0.02);
}

TEST_CASE("a coarse mesh that hits the force by chance is not the cheapest") {
  std::vector<MeshStudyRow> rows{row(500, Element::linear, 1.01), row(2000, Element::linear, 1.5),
                                 row(16000, Element::linear, 1.2), row(2000, Element::quadratic, 1.05)};
  rows.back().work = 4000;
  compare(rows, {.force = 1});
  REQUIRE(cheapest(rows, 0.1));
  CHECK(*cheapest(rows, 0.1) == 3);
  CHECK(*cheapest(rows, 0.6) == 0);
}

TEST_CASE(
    "the uncertainty of the limit is small where all meshes follow one law, and large where they do not") {
  std::vector<MeshStudyRow> rows;
  for (const std::size_t n : {1000, 8000, 64'000}) {
    rows.push_back(row(n, Element::linear, 2 + 3 * std::pow(size_of(n), 2.0)));
    rows.push_back(row(n, Element::quadratic, 2 + 9 * std::pow(size_of(n), 3.0)));
  }
  const double regular = extrapolated(rows).uncertainty;
  CHECK(regular < 1e-3);
  rows[2].force *= 1.01, rows[4].force *= 0.98;
  CHECK(extrapolated(rows).uncertainty > 5 * regular);
}
