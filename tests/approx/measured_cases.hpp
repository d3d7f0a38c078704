#pragma once
// Sets of measured forces and ten variants of each: rotated, in other units, of other size, in another order of rows,
// with other noise.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "approx/methods/evaluate.hpp"

namespace forefeel::test {

// Places and their true force; noise: deviation of a component of the known forces [N].
struct MeasuredCase {
  std::vector<Vec3> at = {}, force = {}, points = {}, truth = {};
  double noise = 0;
  std::vector<State> states() const { return measured_states(at, force); }
  double largest() const {
    double most = 0;
    for (const Vec3& f : truth) most = std::max(most, f.norm());
    return most;
  }
};

// What a variant changes. The rotation turns positions and forces; length and newtons are the size of a unit.
struct Variant {
  unsigned seed = 0;
  Mat3 turn = Mat3::Identity();
  double length = 1, newtons = 1, noise = 1;
};

inline std::vector<Variant> ten_variants() {
  std::vector<Variant> all;
  std::mt19937 random(44);
  std::normal_distribution<double> normal;
  for (unsigned k = 0; k < 10; ++k) {
    Variant v{.seed = k};
    if (k > 0)
      v.turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                   .normalized()
                   .toRotationMatrix();
    v.length = std::array{1.0, 1.0, 3.0, 0.3, 1.0, 1e3, 10.0, 0.1, 2.0, 0.5}[k];
    v.newtons = std::array{1.0, 1.0, 1.0, 10.0, 0.01, 1.0, 1e3, 0.2, 5.0, 1.0}[k];
    v.noise = std::array{1.0, 0.5, 2.0, 1.0, 0.2, 1.0, 0.5, 2.0, 1.0, 0.3}[k];
    all.push_back(v);
  }
  return all;
}

inline void apply(const Variant& v, MeasuredCase& given) {
  for (std::vector<Vec3>* places : {&given.at, &given.points})
    for (Vec3& x : *places) x = v.turn * (v.length * x);
  for (std::vector<Vec3>* forces : {&given.force, &given.truth})
    for (Vec3& f : *forces) f = v.turn * (v.newtons * f);
  given.noise *= v.newtons;
  std::mt19937 random(v.seed + 100);
  for (std::size_t i = given.at.size(); v.seed > 0 && i > 1; --i) {
    const std::size_t j = random() % i;
    std::swap(given.at[i - 1], given.at[j]);
    std::swap(given.force[i - 1], given.force[j]);
  }
}

inline std::vector<double> errors_of(const Evaluation& found, const MeasuredCase& given) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < given.truth.size(); ++i)
    errors.push_back((found.made.forces[i] - given.truth[i]).norm());
  return errors;
}

// Share of the errors within their 95 % bars.
inline double held(const Evaluation& found, const std::vector<double>& errors) {
  double count = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) count += errors[i] <= found.bars->at[i][1] ? 1 : 0;
  return count / double(errors.size());
}

}  // namespace forefeel::test
