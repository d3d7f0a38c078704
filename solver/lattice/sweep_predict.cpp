// The predictions of a sweep.
#include <algorithm>

#include "geometry/common/in_best_set.hpp"
#include "solver/lattice/sweep.hpp"

namespace forefeel {
namespace {

// One corner's contribution in predict_hermite.
FOREFEEL_INLINE void add_corner(std::size_t size, const double* __restrict u, const double* __restrict v,
                                double share, const double* move, const double* slope, const double* keep,
                                double* __restrict to, double* __restrict tangent) {
  const double* __restrict va = v, * __restrict vb = v + size, * __restrict vc = v + 2 * size;
  double* __restrict ta = tangent, * __restrict tb = tangent + size, * __restrict tc = tangent + 2 * size;
  const double ma = 0.5 * move[0], mb = 0.5 * move[1], mc = 0.5 * move[2];
  const double sa = slope[0], sb = slope[1], sc = slope[2], ka = keep[0], kb = keep[1], kc = keep[2];
  for (std::size_t i = 0; i < size; ++i) {
    const double a = ma * va[i], b = mb * vb[i], c = mc * vc[i], all = u[i] + a + b + c;
    to[i] += share * all;
    ta[i] += sa * (all - a) + ka * va[i];
    tb[i] += sb * (all - b) + kb * vb[i];
    tc[i] += sc * (all - c) + kc * vc[i];
  }
}

void add_scaled(const double* from, double factor, double* to, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) to[i] += factor * from[i];
}

}  // namespace

// The tangent of the parent, with V extrapolated linearly along the node opposite to this one across the parent.
std::vector<double> SweepWorker::extrapolated(const SweepNode& node, const SweepNode& parent,
                                              const SweepNode* beyond) const {
  const Vec3 move = node.state.at - parent.state.at;
  std::vector<double> u;
  detail::predict(parent.field, move, node.state.at, u);
  if (!beyond) return u;
  const double share = 0.5 * move.norm() / (parent.state.at - beyond->state.at).norm();
  const std::size_t size = u.size(), rows = static_cast<std::size_t>(3 * d_->free_nodes);
  for (unsigned c = 0; c < 3; ++c) {
    const double along = share * move[c];
    if (along == 0) continue;
    add_scaled(parent.field.tangent.data() + c * size, along, u.data(), rows);
    add_scaled(beyond->field.tangent.data() + c * size, -along, u.data(), rows);
  }
  return u;
}

// With m axes towards rest the other corners T of the box between the node and rest are known, and
//   u = sum over T of (-1)^(m - |T| + 1) u_T + 1/m sum over axes r, T without r, of (-1)^(m - 1 - |T|) d_r V_r(T)
// with |T| the number of axes along which T lies as far out as the node, and d_r the step along r: exact up to the
// fourth mixed derivatives.
std::optional<std::vector<double>> SweepWorker::predict_mixed(const SweepNode& node) const {
  const std::vector<LatticeIndex> inner = inner_corners(options_.planes, node.index);
  if (inner.size() < 4 || !options_.coarse) return std::nullopt;
  const std::size_t size = static_cast<std::size_t>(d_->local_size());
  const int axes = inner.size() == 4 ? 2 : 3;
  std::vector<double> u(size, 0.0);
  for (const LatticeIndex& corner : inner) {
    if (corner == node.index) continue;
    const SweepNode* known = options_.coarse(corner);
    if (!known) return std::nullopt;
    int inward = 0;
    for (std::size_t r = 0; r < 3; ++r) inward += corner[r] != node.index[r];
    const double sign = inward % 2 == 0 ? -1 : 1;
    add_scaled(known->field.u.data(), sign, u.data(), size);
    for (std::size_t r = 0; r < 3; ++r)
      if (corner[r] != node.index[r])
        add_scaled(known->field.tangent.data() + r * size,
                   sign * options_.spacing * (node.index[r] - corner[r]) / axes, u.data(), size);
  }
  std::copy_n(node.state.at.data(), 3, u.end() - 6);  // the contact; the clamp is last
  return u;
}

// The one of several predictions with the least residual.
void SweepWorker::predict_coarse(SweepNode& node, const std::vector<const SweepNode*>& parents,
                                 const SweepNode* beyond) {
  std::vector<LocalField> guesses;
  if (auto mixed = predict_mixed(node)) guesses.push_back({std::move(*mixed), {}});
  guesses.push_back({extrapolated(node, *parents.front(), beyond), {}});
  for (const SweepNode* parent : parents) guesses.push_back({extrapolated(node, *parent, nullptr), {}});
  std::vector<LocalField*> fields;
  for (LocalField& guess : guesses) fields.push_back(&guess);
  const std::array<double, lane_count> residual = lanes_.residuals(fields);
  std::size_t best = 0;
  for (std::size_t i = 1; i < fields.size(); ++i)
    if (residual[i] < residual[best]) best = i;
  node.field.u = std::move(guesses[best].u);
}

// u = mean of u_c + V_c (x - x_c)/2 over the corners; along an axis j between two corners the tangent is the
// derivative of the cubic there, 3/2 (u+ - u-)/(2h) - V_j/2, and elsewhere the corners' mean. False if some of the
// corners are not known.
bool SweepWorker::predict_hermite(SweepNode& node, const std::vector<const SweepNode*>& corners) const {
  std::array<bool, 3> between{};
  std::size_t wanted = 1;
  for (std::size_t j = 0; j < 3; ++j) {
    between[j] = !std::ranges::binary_search(options_.planes.at[j], node.index[j]);
    wanted *= between[j] ? 2 : 1;
  }
  if (corners.size() != wanted) return false;
  const double share = 1.0 / static_cast<double>(corners.size()), h = options_.spacing;
  LocalField& f = node.field;
  const std::size_t size = static_cast<std::size_t>(d_->local_size());
  f.u.assign(size, 0.0);
  f.tangent.assign(3 * size, 0.0);
  for (const SweepNode* corner : corners) {
    Vec3 move = node.state.at - corner->state.at, slope, keep;
    for (unsigned j = 0; j < 3; ++j) {
      const bool mid = between[j];
      if (!mid) move[j] = 0;
      // the state lies at +h along j from this corner: the corner is on the low side
      slope[j] = mid ? (move[j] > 0 ? -1.5 : 1.5) / h * share : 0.0;
      keep[j] = (mid ? -0.5 : 1.0) * share;
    }
    in_best_set<add_corner>(size, corner->field.u.data(), corner->field.tangent.data(), share, move.data(),
                            slope.data(), keep.data(), f.u.data(), f.tangent.data());
  }
  return true;
}

void SweepWorker::predict_fine(SweepNode& node, const std::vector<const SweepNode*>& corners) const {
  if (!predict_hermite(node, corners)) {
    const SweepNode& corner = *corners.front();
    node.field.tangent = corner.field.tangent;
    detail::predict(corner.field, node.state.at - corner.state.at, node.state.at, node.field.u);
  }
  std::copy_n(node.state.at.data(), 3, node.field.u.end() - 6);
}

}  // namespace forefeel
