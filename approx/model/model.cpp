#include "approx/model/model.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "approx/loops/jet_sums.hpp"
#include "approx/loops/kernel_sums.hpp"
#include "approx/model/lattice_field.hpp"
#include "approx/model/model_data.hpp"
#include "approx/model/model_options.hpp"

namespace forefeel {

namespace {

// The 13 axes of the planes that bound a set: faces, edges and corners of a cube.
struct Axes {
  double d[13][3];
  Axes() {
    int count = 0;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          if (9 * x + 3 * y + z <= 0) continue;  // one of each pair
          const double length = std::sqrt(double(x * x + y * y + z * z));
          d[count][0] = x / length;
          d[count][1] = y / length;
          d[count++][2] = z / length;
        }
  }
};
const Axes axes;

// h(a): a itself up to keep, then smoothly on to limit; with its derivative.
double soften(double a, double keep, double limit, double& derivative) {
  derivative = 1;
  if (a <= keep) return a;
  const double room = limit - keep, t = (a - keep) / room;
  if (!(t < 1e8)) {
    derivative = 0;
    return limit;
  }
  const double root = std::sqrt(1 + t * t);
  derivative = 1 / (root * root * root);
  return keep + room * (t / root);
}

// v scaled to length h(|v|); jacobian (of v) is carried along where given.
Vec3 saturate(const Vec3& v, double keep, double limit, Mat3* jacobian) {
  const double squared = v.squaredNorm();
  if (squared <= keep * keep) return v;
  const double length = v.stableNorm();
  if (!(length > 0)) return v;  // also keep = 0 and v = 0
  double slope;
  const double wanted = soften(length, keep, limit, slope) * (1 - 1e-15);
  if (!std::isfinite(length)) {
    if (jacobian != nullptr) jacobian->setZero();
    return Vec3::Zero();
  }
  const Vec3 unit = v / length;
  if (jacobian != nullptr) {
    const double ratio = wanted / length;
    *jacobian = (ratio * (*jacobian) + (slope - ratio) * unit * (unit.transpose() * (*jacobian))).eval();
  }
  return wanted * unit;
}

// Quintic step from 0 to 1 on [0, 1].
double step(double t, double& derivative) {
  derivative = 0;
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  derivative = 30 * t * t * (1 - t) * (1 - t);
  return t * t * t * (10 + t * (6 * t - 15));
}

}  // namespace

void ModelData::reserve(const ModelOptions& options) {
  reserve(most_neighbours(options) + affine_places(options), options.data != Data::force);
  if (options.data != Data::jet) return;
  const std::size_t most = std::min(options.neighbours, most_jets);
  jets.data.reserve((most + jets::lanes - 1) / jets::lanes * jets::block_size);
}

void ModelData::reserve(std::size_t wanted, bool with_stiffness) {
  const std::size_t rounded = (wanted + 7) / 8 * 8;
  states.reserve(rounded);
  const std::size_t arrays = with_stiffness ? 15 : 6;
  if (sum.stride < rounded || sum.data.size() < arrays * sum.stride) {
    fast.function = nullptr;
    sum.stride = std::max(sum.stride, rounded);
    sum.data.assign(std::max(sum.data.size(), arrays * sum.stride), 0.0);
  }
}

void ModelData::clear() {
  states.clear();
  lattice.reset();
  jets.blocks = 0;
  sum.power = 0;
  sum.degree = 0;
  sum.padded = 0;
  sum.hermite = false;
  known = false;
  bound = 0;
  domain.hull.inner_squared = domain.quick = -1;
  domain.bridge = 0;
  fast.function = nullptr;
}

void ModelData::prepare() {
  if (sum.power == 0 || !(domain.quick > 0)) return;
  const double each = full_share * bound / std::sqrt(3.0) * (1 - 1e-15);  // so that |f| keeps below
  for (int d = 0; d < 3; ++d) {
    fast.sum.centre[d] = sum.centre[d];
    fast.sum.limit[d] = each;
  }
  fast.sum.inverse_scale = sum.inverse_scale;
  fast.sum.limit[3] = domain.quick;
  fast.sum.n = sum.padded;
  fast.sum.stride = sum.stride;
  fast.sum.data = sum.data.data();
  fast.sum.polynomial = sum.polynomial[0].data();
  fast.function = sum.loops->quick[sum.hermite ? 1 : 0][sum.power / 2];
}

void ModelData::RbfSum::raw(const double y[3], double f[3]) const noexcept {
  (hermite ? loops->hermite : loops->plain)(power, padded, data.data(), stride, polynomial[0].data(), y, f);
}

void ModelData::RbfSum::raw(const double y[3], double f[3], double j[9]) const noexcept {
  (hermite ? loops->hermite_jacobian : loops->plain_jacobian)(power, padded, data.data(), stride,
                                                              polynomial[0].data(), y, f, j);
}

// E = (sum g_k^8)^(1/8), g_k the distance beyond plane k where positive: smooth, and within a few per cent of
// the distance to the polytope.
double ModelData::Hull::outside(const double y[3], double gradient[3]) const noexcept {
  double g[13], largest = 0;
  for (std::size_t k = 0; k < 13; ++k) {
    const double along = axes.d[k][0] * y[0] + axes.d[k][1] * y[1] + axes.d[k][2] * y[2];
    g[k] = along > high[k] ? along - high[k] : along < low[k] ? along - low[k] : 0;
    largest = std::max(largest, std::abs(g[k]));
  }
  gradient[0] = gradient[1] = gradient[2] = 0;
  if (largest == 0) return 0;
  double powers = 0, weight[13];
  for (int k = 0; k < 13; ++k) {
    const double t = g[k] / largest, t2 = t * t, t4 = t2 * t2;
    weight[k] = t4 * t2 * t;
    powers += t4 * t4;
  }
  const double root = std::sqrt(std::sqrt(std::sqrt(powers)));
  const double scale_down = root / powers;  // d/dg_k = (g_k / largest)^7 sum^(-7/8)
  for (int k = 0; k < 13; ++k)
    for (int d = 0; d < 3; ++d) gradient[d] += scale_down * weight[k] * axes.d[k][d];
  return largest * root;
}

void ModelData::Hull::set(const double* px, const double* py, const double* pz, std::size_t n,
                          double trusted) {
  sums::loops().supports(n, px, py, pz, axes.d, low.data(), high.data());
  double nearest = 1e300;
  for (std::size_t k = 0; k < 13; ++k) nearest = std::min({nearest, high[k], -low[k]});
  const double radius = nearest + trusted / 1.4;  // 13^(1/8) < 1.4
  inner_squared = radius > 0 ? radius * radius : -1;
}

namespace {

// An older method; its Jacobian by central differences.
Vec3 on_lattice(const LatticeField& field, const Vec3& x, Mat3* jacobian) noexcept {
  if (jacobian != nullptr)
    for (int d = 0; d < 3; ++d) {
      const Vec3 step = 1e-6 * Vec3::Unit(d);
      jacobian->col(d) = (field.force(x + step) - field.force(x - step)) / 2e-6;
    }
  return field.force(x);
}

// A blend of jets; up to hold / 2 from the centre it is a potential.
Vec3 of_jets(const ModelData& m, const Vec3& x, Mat3* jacobian, jets::Blend& blend) noexcept {
  const double keep = ModelData::full_share * m.bound;
  Mat3 moved = Mat3::Identity();
  const Vec3 at = x.allFinite() ? Vec3(m.jets.centre + saturate(x - m.jets.centre, 0.5 * m.jets.hold,
                                                                m.jets.hold, jacobian ? &moved : nullptr))
                                : m.jets.centre;
  jets::loops().blend(m.jets.blocks, m.jets.data.data(), at.data(), blend);
  const double* const h = blend.hessian;
  if (jacobian != nullptr) {
    Mat3 bend;
    bend << h[0], h[3], h[4], h[3], h[1], h[5], h[4], h[5], h[2];
    *jacobian = -bend * moved;
  }
  return saturate(-Eigen::Map<const Vec3>(blend.gradient), keep, m.bound, jacobian);
}

// Force (and Jacobian over x) at x; one path for both.
Vec3 bounded(const ModelData& m, const Vec3& x, Mat3* jacobian) noexcept {
  if (m.lattice) return on_lattice(*m.lattice, x, jacobian);
  if (m.jets.blocks > 0) {
    jets::Blend blend;
    return of_jets(m, x, jacobian, blend);
  }
  if (jacobian != nullptr) jacobian->setZero();
  if (!m.known) return Vec3::Zero();
  const double keep = ModelData::full_share * m.bound;
  const Vec3 y = (x - m.sum.centre) * m.sum.inverse_scale;
  const double y2 = y.squaredNorm();
  const auto rbf = [&](Mat3* gradient) {
    double f[3], j[9];
    if (gradient == nullptr) {
      m.sum.raw(y.data(), f);
    } else {
      m.sum.raw(y.data(), f, j);
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) (*gradient)(c, d) = j[3 * c + d] * m.sum.inverse_scale;
    }
    return saturate(Vec3(f[0], f[1], f[2]), keep, m.bound, gradient);
  };
  if (y2 <= m.domain.quick) return rbf(jacobian);

  if (!x.allFinite()) return saturate(m.tangent.force, keep, m.bound, nullptr);
  double slope = 0, weight = 1, gradient[3] = {};
  if (m.sum.power != 0 && y2 < 1e16) {
    weight = step(m.domain.hull.outside(y.data(), gradient) / m.domain.trust - 1, slope);
    if (m.domain.bridge > 0) {
      double wider[3], wider_slope = 0;
      const double both = step(m.domain.whole.outside(y.data(), wider) / m.domain.trust - 1, wider_slope);
      weight += m.domain.bridge * (both - weight);
      for (int d = 0; d < 3; ++d)
        gradient[d] = (1 - m.domain.bridge) * slope * gradient[d] + m.domain.bridge * wider_slope * wider[d];
      slope = 1;
    }
  }
  Vec3 force = Vec3::Zero(), inner = Vec3::Zero();
  if (weight < 1) inner = rbf(jacobian);
  force = inner;
  if (weight > 0) {
    Mat3 moved = Mat3::Identity();
    const Vec3 away = saturate(x - m.tangent.at, 0.5 * m.tangent.hold, m.tangent.hold,
                               jacobian != nullptr ? &moved : nullptr);
    Mat3 tangent = m.tangent.jacobian * moved;
    const Vec3 outer = saturate(m.tangent.force + m.tangent.jacobian * away, keep, m.bound,
                                jacobian != nullptr ? &tangent : nullptr);
    force = (1 - weight) * inner + weight * outer;
    if (jacobian != nullptr) {
      const double per_metre = slope / m.domain.trust * m.sum.inverse_scale;
      *jacobian = (1 - weight) * (*jacobian) + weight * tangent;
      *jacobian += (outer - inner) * (per_metre * Vec3(gradient[0], gradient[1], gradient[2])).transpose();
    }
  }
  return force;
}

}  // namespace

Model::Model() : data_(std::make_unique<ModelData>()) {}
Model::~Model() = default;
Model::Model(Model&&) noexcept = default;
Model& Model::operator=(Model&&) noexcept = default;

Vec3 Model::force(const Vec3& x) const noexcept {
  const ModelData& m = *data_;
  Vec3 f;
  // nearly always: the sum alone, far below the bound
  if (m.fast.function == nullptr || !m.fast.function(m.fast.sum, x.data(), f.data()))
    f = bounded(m, x, nullptr);
  return f;
}

void Model::evaluate(const Vec3& x, Vec3& force, Mat3& jacobian) const noexcept {
  force = bounded(*data_, x, &jacobian);
}

std::span<const StateId> Model::states() const noexcept {
  return data_->states;
}
Kernel Model::kernel() const noexcept {
  return data_->sum.kernel;
}
int Model::degree() const noexcept {
  return data_->sum.degree;
}
bool Model::is_tangent() const noexcept {
  return data_->known && data_->sum.power == 0 && data_->jets.blocks == 0;
}
bool Model::has_jets() const noexcept {
  return data_->jets.blocks > 0;
}
Answer Model::at(const Place& place) const noexcept {
  Answer answer{.reach = {force_bound(), 2 * trust_distance(), hold_distance()},
                .kernel = is_tangent()    ? "tangent"
                          : has_jets()    ? "jets"
                          : degree() == 0 ? "linear with constant"
                                          : name(kernel())};
  if (!has_jets()) {
    answer.force = force(place.x);
    return answer;
  }
  jets::Blend blend;
  answer.force = of_jets(*data_, place.x, nullptr, blend);
  answer.error = std::max({blend.estimate, blend.spread, blend.mixing});
  answer.trusted = blend.confirmed >= 0.5 && answer.error <= data_->jets.tolerance.limit(answer.force.norm());
  return answer;
}
double Model::force_bound() const noexcept {
  return data_->bound;
}
std::uint64_t Model::serial() const noexcept {
  return data_->serial;
}
double Model::trust_distance() const noexcept {
  if (has_jets()) return data_->jets.trusted;
  return data_->known ? data_->domain.trust * data_->sum.scale : 0;
}
double Model::hold_distance() const noexcept {
  if (has_jets()) return data_->jets.hold;
  return data_->known ? data_->tangent.hold : 0;
}
bool Model::uses_stiffness() const noexcept {
  return data_->sum.hermite;
}

void Model::reserve(const ModelOptions& options) {
  data_->reserve(options);
}

void Model::assign(ModelDraft& draft, std::uint64_t serial) noexcept {
  data_.swap(draft.data_);
  data_->serial = serial;
}

ModelDraft::ModelDraft() : data_(std::make_unique<ModelData>()) {}
ModelDraft::~ModelDraft() = default;
ModelDraft::ModelDraft(ModelDraft&&) noexcept = default;
ModelDraft& ModelDraft::operator=(ModelDraft&&) noexcept = default;

void ModelDraft::reserve(const ModelOptions& options) {
  data_->reserve(options);
}

void ModelDraft::clear() {
  data_->clear();
}

void ModelDraft::set_lattice(std::shared_ptr<const LatticeField> field, std::span<const StateId> states) {
  data_->clear();
  data_->states.assign(states.begin(), states.end());
  data_->lattice = std::move(field);
  data_->known = true;
}

void ModelDraft::forget_states() {
  data_->states.clear();
}

}  // namespace forefeel
