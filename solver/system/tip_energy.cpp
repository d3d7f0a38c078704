#include "solver/system/tip_energy.hpp"

#include "solver/kernels/kernels.hpp"

namespace forefeel {
namespace {

using Row = Eigen::Map<Vec3>;
using ConstRow = Eigen::Map<const Vec3>;
// One lane of a node's row in lanes.
using LaneRow = Eigen::Map<Vec3, 0, Eigen::InnerStride<lane_count>>;
using ConstLaneRow = Eigen::Map<const Vec3, 0, Eigen::InnerStride<lane_count>>;

}  // namespace

double TipEnergy::add_gradient(const double* u, double* r) const {
  if (!jet) return 0;
  const JetTerms terms = jet->at(ConstRow(u + 3 * node));
  Row(r + 3 * node) += terms.gradient;
  return terms.energy;
}

void TipEnergy::add_hessian(const double* u, double* blocks) const {
  if (!jet) return;
  Eigen::Map<Mat3>(blocks + 9 * block) += jet->at(ConstRow(u + 3 * node)).hessian;  // symmetric
}

void TipEnergy::add_gradient_lanes(const double* u, double* r, double* energy) const {
  if (!jet) return;
  const std::int64_t row = 3 * lane_count * node;
  for (int lane = 0; lane < lane_count; ++lane) {
    const JetTerms terms = jet->at(ConstLaneRow(u + row + lane));
    LaneRow(r + row + lane) += terms.gradient;
    *(energy + lane) += terms.energy;
  }
}

void TipEnergy::add_product(std::int64_t stride, const double* u, const double* d, double* y) const {
  if (!jet) return;
  const Mat3 hessian = jet->at(ConstRow(u + 3 * node)).hessian;
  for (std::int64_t c = 0; c < 3; ++c)
    Row(y + c * stride + 3 * node) += hessian * ConstRow(d + c * stride + 3 * node);
}

void TipEnergy::add_product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const {
  if (!jet) return;
  const std::int64_t row = 3 * lane_count * node;
  for (int lane = 0; lane < lane_count; ++lane) {
    const Mat3 hessian = jet->at(ConstLaneRow(u + row + lane)).hessian;
    for (std::int64_t c = 0; c < 3; ++c)
      LaneRow(y + c * stride + row + lane) += hessian * ConstLaneRow(d + c * stride + row + lane);
  }
}

}  // namespace forefeel
