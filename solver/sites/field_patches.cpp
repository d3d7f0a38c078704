#include "solver/sites/field_patches.hpp"

#include <Eigen/Geometry>

#include "solver/sites/site_turns.hpp"

namespace forefeel {
namespace {

constexpr int places = 10;                                      // of a cubic on a triangle
constexpr int quantities = 6 + 3 + static_cast<int>(jet_size);  // K, the normal, degrees 3 to 5

// The places in thirds of the barycentric coordinates: corners, two on each edge, the middle.
constexpr std::array<std::array<int, 3>, places> thirds{{{3, 0, 0},
                                                         {0, 3, 0},
                                                         {0, 0, 3},
                                                         {2, 1, 0},
                                                         {1, 2, 0},
                                                         {0, 2, 1},
                                                         {0, 1, 2},
                                                         {1, 0, 2},
                                                         {2, 0, 1},
                                                         {1, 1, 1}}};

// Lagrange's cubic shape functions and their derivatives by the barycentric coordinates.
struct Shape {
  Eigen::Matrix<double, places, 1> value;
  Eigen::Matrix<double, places, 3> slope;
};
Shape shape_at(const Vec3& b) {
  // Of one coordinate: 1, 3 b, 3 b (3 b - 1) / 2, 3 b (3 b - 1) (3 b - 2) / 6.
  std::array<std::array<double, 4>, 3> part{}, by{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = b[static_cast<int>(i)];
    part[i] = {1, 3 * t, 1.5 * t * (3 * t - 1), 0.5 * t * (3 * t - 1) * (3 * t - 2)};
    by[i] = {0, 3, 9 * t - 1.5, 13.5 * t * t - 9 * t + 1};
  }
  Shape shape;
  for (int k = 0; k < places; ++k) {
    const auto& third = thirds[static_cast<std::size_t>(k)];
    const auto a = static_cast<std::size_t>(third[0]), c = static_cast<std::size_t>(third[1]),
               d = static_cast<std::size_t>(third[2]);
    shape.value[k] = part[0][a] * part[1][c] * part[2][d];
    shape.slope.row(k) << by[0][a] * part[1][c] * part[2][d], part[0][a] * by[1][c] * part[2][d],
        part[0][a] * part[1][c] * by[2][d];
  }
  return shape;
}

Mat3 symmetric(const Eigen::Matrix<double, 6, 1>& v) {
  Mat3 m;
  m << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  return m;
}

}  // namespace

struct FieldPatches::Patch {
  Eigen::Matrix<double, quantities, places> values;
};

FieldPatches::FieldPatches(std::shared_ptr<const SiteField> field)
    : field_(std::move(field)), patches_(field_->rest().map().facets().size()) {}
FieldPatches::~FieldPatches() = default;

bool FieldPatches::has(std::int32_t facet) const {
  return patches_[static_cast<std::size_t>(facet)].load(std::memory_order_acquire) != nullptr;
}

void FieldPatches::make(std::int32_t facet) {
  if (has(facet)) return;
  auto patch = std::make_unique<Patch>();
  const auto [a, b, c] = field_->rest().map().corners(facet);
  for (int k = 0; k < places; ++k) {
    const auto& third = thirds[static_cast<std::size_t>(k)];
    const SiteModel model = field_->at({facet, (third[0] * a + third[1] * b + third[2] * c) / 3}, false);
    const Mat3& stiffness = model.rest().stiffness;
    patch->values.col(k) << stiffness(0, 0), stiffness(0, 1), stiffness(0, 2), stiffness(1, 1),
        stiffness(1, 2), stiffness(2, 2), model.rest().normal, model.polynomial();
  }
  patches_[static_cast<std::size_t>(facet)].store(patch.get(), std::memory_order_release);
  made_.push_back(std::move(patch));
}

void FieldPatches::fill(const SurfacePlace& place, bool root, SiteModel& model) const {
  const Patch& patch = *patches_[static_cast<std::size_t>(place.facet)].load(std::memory_order_acquire);
  const SurfaceMap& map = field_->rest().map();
  const Shape shape = shape_at(map.barycentric(place));
  const std::array<Vec3, 3> by = barycentric_slopes(map, place.facet);
  Mat3 to_space;  // row i: of the coordinate i
  to_space << by[0].transpose(), by[1].transpose(), by[2].transpose();
  const Eigen::Matrix<double, quantities, 1> value = patch.values * shape.value;
  const Eigen::Matrix<double, quantities, 3> slope =
      patch.values * Eigen::Matrix<double, places, 3>(shape.slope * to_space);
  SiteRest rest;
  rest.stiffness = symmetric(value.head<6>());
  for (int k = 0; k < 3; ++k)
    rest.stiffness_by[static_cast<std::size_t>(k)] = symmetric(slope.col(k).head<6>());
  const Vec3 sum = value.segment<3>(6);
  const double length = sum.norm();
  rest.normal = sum / length;
  rest.normal_by =
      (Mat3::Identity() - rest.normal * rest.normal.transpose()) / length * slope.middleRows<3>(6);
  model.take(rest, value.tail<static_cast<int>(jet_size)>(), slope.bottomRows<static_cast<int>(jet_size)>(),
             root, field_->options().theta);
}

}  // namespace forefeel
