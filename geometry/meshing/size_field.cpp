#include "geometry/meshing/size_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace forefeel {
namespace {

constexpr double shape = 0.15;          // volume of a tetrahedron over h^3
constexpr double far_share = 1.144714;  // of the uniform edge: 1.5^(1/3)
constexpr int shells = 256;

double cube(double x) {
  return x * x * x;
}

double cube_root(double x) {
  double low = 0, high = std::max(1.0, x);
  for (int k = 0; k < 1100 && high - low > 1e-15 * high; ++k) {
    const double middle = 0.5 * (low + high);
    (cube(middle) < x ? low : high) = middle;
  }
  return high;
}

// Volume of a body within the distance R of the site, for growing R. By the divergence theorem it is the integral over
// the surface of (y - s).n min(|y - s|, R)^3 / (3 |y - s|^3).
class Shells {
 public:
  Shells(const Surface& closed, const Vec3& site) {
    double reach = 0;
    for (const Vec3& node : closed.nodes) reach = std::max(reach, (node - site).norm());
    width_ = reach / shells;
    std::vector<double> inside(shells + 1, 0);
    for (const auto& [a, b, c] : closed.triangles)
      add({closed.nodes[a] - site, closed.nodes[b] - site, closed.nodes[c] - site}, 0, inside);
    for (std::size_t k = 0; k < shells; ++k) volume_[k] = std::max(0.0, inside[k + 1] - inside[k]);
  }

  double count(const SizeField& field) const {
    double sum = 0;
    for (std::size_t k = 0; k < shells; ++k)
      sum += volume_[k] / (shape * cube(field.at_distance((static_cast<double>(k) + 0.5) * width_)));
    return sum;
  }

 private:
  // One value a triangle, which is cut in four where it is large for its distance.
  void add(const std::array<Vec3, 3>& t, int depth, std::vector<double>& inside) const {
    const Vec3 centre = (t[0] + t[1] + t[2]) / 3;
    const double distance = centre.norm();
    const double side = std::sqrt(
        std::max({(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()}));
    if (depth < 6 && side > std::max(0.3 * distance, 4 * width_)) {
      const Vec3 u = (t[0] + t[1]) / 2, v = (t[1] + t[2]) / 2, w = (t[2] + t[0]) / 2;
      for (const std::array<Vec3, 3>& part :
           {std::array{t[0], u, w}, std::array{u, t[1], v}, std::array{w, v, t[2]}, std::array{u, v, w}})
        add(part, depth + 1, inside);
      return;
    }
    const double flux = centre.dot((t[1] - t[0]).cross(t[2] - t[0])) / 6;
    for (std::size_t k = 0; k <= shells; ++k) {
      const double radius = static_cast<double>(k) * width_;
      inside[k] += distance > radius ? flux * cube(radius / distance) : flux;
    }
  }

  double width_ = 0;  // [m]
  std::array<double, shells> volume_{};
};

// The x between low and high where a falling function meets the value; an end where it does not.
template <class Function>
double solve_falling(double low, double high, double value, const Function& at) {
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (at(middle) > value ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double SizeField::at_distance(double from_site) const {
  return std::min(far, near + growth * std::max(0.0, from_site - radius));
}

double uniform_edge(const Surface& closed, std::size_t elements) {
  return cube_root(enclosed_volume(closed) / (shape * static_cast<double>(elements)));
}

SizeField size_field(const Surface& closed, const Toward& toward, std::size_t elements) {
  const auto wanted = static_cast<double>(elements);
  const double uniform = uniform_edge(closed, elements);
  const Shells body(closed, toward.site);
  SizeField field{.site = toward.site, .radius = toward.radius, .near = uniform, .far = far_share * uniform};
  const double least = std::min(uniform, least_near * toward.radius);
  const auto with_near = [&](double near) {
    field.near = near;
    return body.count(field);
  };
  field.near = solve_falling(least, uniform, wanted, with_near);
  if (field.near > least * 1.0001) return field;
  field.near = least;
  field.far = solve_falling(least, field.far, wanted, [&](double far) {
    field.far = far;
    return body.count(field);
  });
  return field;
}

}  // namespace forefeel
