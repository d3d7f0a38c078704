#include <Eigen/LU>

#include "solver/body/law.hpp"
#include "solver/kernels/kernels.hpp"
#include "tests/support/test.hpp"

namespace {

// The laws whose density is written out below. The derivatives of all_laws() are tested, too.
const Law laws[] = {Law::linear, Law::st_venant_kirchhoff, Law::neo_hookean, Law::stable_neo_hookean,
                    Law::mooney_rivlin};

// The densities as the header writes them, term by term.
double density(Law law, const Material& material, const Mat3& f) {
  const double mu = material.young / (2 * (1 + material.poisson));
  const double lambda =
      material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  const Mat3 c = f.transpose() * f;
  const double i1 = c.trace(), i2 = 0.5 * (i1 * i1 - (c * c).trace()), j = f.determinant();
  if (law == Law::linear) {
    const Mat3 e = 0.5 * (f + f.transpose()) - Mat3::Identity();
    return 0.5 * lambda * e.trace() * e.trace() + mu * e.squaredNorm();
  }
  if (law == Law::st_venant_kirchhoff) {
    const Mat3 g = 0.5 * (c - Mat3::Identity());
    return 0.5 * lambda * g.trace() * g.trace() + mu * g.squaredNorm();
  }
  const double volume = 0.5 * lambda * std::log(j) * std::log(j);
  if (law == Law::neo_hookean) return 0.5 * mu * (i1 - 3) - mu * std::log(j) + volume;
  if (law == Law::mooney_rivlin) {
    const double c1 = 0.35 * mu, c2 = 0.15 * mu;
    return c1 * (i1 - 3 - 2 * std::log(j)) + c2 * (i2 - 3 - 4 * (j - 1)) + volume;
  }
  const double m = 4 * mu / 3, l = lambda + 5 * mu / 6, a = 1 + m / l - m / (4 * l);
  return 0.5 * m * (i1 - 3) + 0.5 * l * (j - a) * (j - a) - 0.5 * m * std::log(i1 + 1) -
         (0.5 * l * (1 - a) * (1 - a) - 0.5 * m * std::log(4.0));
}

Mat3 some_deformation(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Mat3 f;
  do {
    f = Mat3::Identity();
    for (int i = 0; i < 9; ++i) f(i / 3, i % 3) += uniform(random);
  } while (f.determinant() < 0.2);
  return f;
}

}  // namespace

TEST_CASE("each law's energy is its formula, counted from rest") {
  std::mt19937 random(1);
  for (const Law law : laws)
    for (const double poisson : {-0.3, 0.0, 0.3, 0.45, 0.499}) {
      const Material material{law, 5000, poisson};
      const LawConstants constants = law_constants(material);
      const double modulus = constants.lambda + 5 * constants.mu / 6;
      CHECK(std::abs(evaluate_law(law, constants, Mat3::Identity()).energy) < 1e-11 * modulus);
      CHECK(evaluate_law(law, constants, Mat3::Identity()).stress.norm() < 1e-11 * modulus);
      for (int trial = 0; trial < 20; ++trial) {
        const Mat3 f = some_deformation(random, 0.4);
        const double expected = density(law, material, f);
        CHECK(evaluate_law(law, constants, f).energy == Approx(expected).epsilon(1e-11).margin(1e-9));
      }
    }
}

TEST_CASE("stress is the energy's derivative and the tangent the stress's, by central differences") {
  std::mt19937 random(2);
  const double h = 1e-5;
  for (const Law law : all_laws())
    for (int trial = 0; trial < 10; ++trial) {
      const LawConstants constants = law_constants({law, 5000, 0.4});
      const Mat3 f = some_deformation(random, 0.35);
      const LawValue value = evaluate_law(law, constants, f);
      Mat3 stress;
      Mat9 tangent;
      for (int i = 0; i < 9; ++i) {
        Mat3 up = f, down = f;
        up(i / 3, i % 3) += h;
        down(i / 3, i % 3) -= h;
        const LawValue high = evaluate_law(law, constants, up), low = evaluate_law(law, constants, down);
        stress(i / 3, i % 3) = (high.energy - low.energy) / (2 * h);
        const Mat3 change = (high.stress - low.stress) / (2 * h);
        for (int k = 0; k < 9; ++k) tangent(k, i) = change(k / 3, k % 3);
      }
      CHECK((stress - value.stress).norm() < 1e-7 * value.tangent.norm());
      CHECK((tangent - value.tangent).norm() < 1e-7 * value.tangent.norm());
      CHECK((value.tangent - value.tangent.transpose()).norm() < 1e-13 * value.tangent.norm());
    }
}

TEST_CASE("at rest all laws have the tangent of the linear one, at every Poisson's ratio") {
  for (const double poisson : {-0.9, -0.3, 0.0, 0.1, 0.1875, 0.3, 0.45, 0.4999}) {
    const Mat9 reference =
        evaluate_law(Law::linear, law_constants({Law::linear, 5000, poisson}), Mat3::Identity()).tangent;
    for (const Law law : all_laws()) {
      INFO(name(law) << ", " << poisson);
      const Mat9 tangent = evaluate_law(law, law_constants({law, 5000, poisson}), Mat3::Identity()).tangent;
      CHECK((tangent - reference).norm() < 1e-12 * reference.norm());
    }
  }
}

TEST_CASE("the energy of Mooney-Rivlin is never negative where lambda is not") {
  std::mt19937 random(3);
  for (const double poisson : {0.0, 0.1, 0.1875, 0.45})
    for (int trial = 0; trial < 300; ++trial) {
      const Mat3 f = some_deformation(random, trial % 2 == 0 ? 0.9 : 0.1);
      CHECK(evaluate_law(Law::mooney_rivlin, law_constants({Law::mooney_rivlin, 5000, poisson}), f).energy >=
            0);
    }
}

TEST_CASE("laws with a logarithm refuse an inverted element, the others do not") {
  Mat3 f = Mat3::Identity();
  f(0, 0) = -0.5;
  for (const Law law : all_laws()) {
    const double energy = evaluate_law(law, law_constants({law, 5000, 0.3}), f).energy;
    CHECK(std::isinf(energy) == needs_positive_jacobian(law));
  }
}
