#include "solver/jet/deep_states.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solver/jet/field_patches.hpp"
#include "solver/jet/site_turns.hpp"

namespace forefeel {
namespace {

constexpr std::size_t series_size = 10 + jet_size;
constexpr double same_place = 1e-9;        // [m]
constexpr double least_square = 1e-12;     // q^2 at a state, where the weight would be infinite
constexpr double least_surprise = 1;       // of the field, until states say more
constexpr double surprise_quantile = 0.8;  // of the states' that counts for other places

std::size_t start_of(int degree) {
  return static_cast<std::size_t>(degree * (degree + 1) * (degree + 2) / 6);
}
std::size_t place_of(int a, int b, int c) {
  const int left = b + c;
  return start_of(a + left) + static_cast<std::size_t>(left * (left + 1) / 2 + c);
}

// A polynomial in d to degree 5; degrees 3 to 5 are those of an EnergyJet.
using Series = Eigen::Matrix<double, static_cast<int>(series_size), 1>;

template <class Visit>
void for_each_power(const Visit& visit) {
  for (int degree = 0; degree <= 5; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) visit(a, b, degree - a - b);
}

double& coefficient(Series& s, int a, int b, int c) {
  return s[static_cast<Eigen::Index>(place_of(a, b, c))];
}

Series product(const Series& p, const Series& q) {
  Series r = Series::Zero();
  for_each_power([&](int a, int b, int c) {
    const double left = p[static_cast<Eigen::Index>(place_of(a, b, c))];
    if (left == 0) return;
    for_each_power([&](int i, int j, int k) {
      if (a + b + c + i + j + k <= 5)
        coefficient(r, a + i, b + j, c + k) += left * q[static_cast<Eigen::Index>(place_of(i, j, k))];
    });
  });
  return r;
}

// 1/2 d^T K d - f . d + e and a jet's terms.
Series series_of(double e, const Vec3& f, const Mat3& k, const JetCoefficients& jet) {
  Series s;
  s << e, -f, 0.5 * k(0, 0), k(0, 1), k(0, 2), 0.5 * k(1, 1), k(1, 2), 0.5 * k(2, 2), jet;
  return s;
}

// p(x + d) as a polynomial in d.
Series moved(const Series& p, const Vec3& x) {
  Series r = Series::Zero();
  constexpr double choose[6][6] = {{1},          {1, 1},          {1, 2, 1},
                                   {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}};
  for_each_power([&](int a, int b, int c) {
    const double value = p[static_cast<Eigen::Index>(place_of(a, b, c))];
    for (int i = 0; i <= a; ++i)
      for (int j = 0; j <= b; ++j)
        for (int k = 0; k <= c; ++k)
          coefficient(r, i, j, k) += value * choose[a][i] * choose[b][j] * choose[c][k] *
                                     std::pow(x[0], a - i) * std::pow(x[1], b - j) * std::pow(x[2], c - k);
  });
  return r;
}

// (|x| / |x + d|)^6.
Series inverse_growth(const Vec3& x) {
  const double square = x.squaredNorm();
  Series u = series_of(0, -2 * x / square, 2 * Mat3::Identity() / square, JetCoefficients::Zero());
  Series power = Series::Zero(), sum = Series::Zero();
  power[0] = 1;
  for (int n = 0; n <= 5; ++n, power = product(power, u))
    sum += (n % 2 == 0 ? 0.5 : -0.5) * (n + 1) * (n + 2) * power;
  return sum;
}

struct Value {
  double value = 0;
  Vec3 slope = Vec3::Zero();
  Mat3 bend = Mat3::Zero();
};

Value value_of(const Series& p, const Vec3& d, int degree) {
  Mat3 k;
  k << 2 * p[4], p[5], p[6], p[5], 2 * p[7], p[8], p[6], p[8], 2 * p[9];
  const Vec3 first = p.segment<3>(1), bent = k * d;
  Value v{p[0] + first.dot(d) + 0.5 * d.dot(bent), first + bent, k};
  if (degree <= 2) return v;
  const JetTerms more = jet_sum(p.tail<static_cast<int>(jet_size)>(), jet_monomials(d), degree);
  v.value += more.energy, v.slope += more.gradient, v.bend += more.hessian;
  return v;
}

Value times(const Value& a, const Value& b) {
  const Mat3 mixed = a.slope * b.slope.transpose();
  return {a.value * b.value, a.value * b.slope + b.value * a.slope,
          a.value * b.bend + b.value * a.bend + mixed + mixed.transpose()};
}

// (|y|^2 / square)^3.
Value growth(const Vec3& y, double square) {
  const double r = y.squaredNorm() / square;
  return {r * r * r, 6 * r * r / square * y,
          6 * r * r / square * Mat3::Identity() + 24 * r / (square * square) * y * y.transpose()};
}

// (1 - q)^3 / q^2 and its derivatives by q.
struct Weight {
  double value = 0, slope = 0, bend = 0;
};
Weight weight_of(double q) {
  const double left = 1 - q, over = q * q + least_square;
  const double value = left * left * left / over, slope = (-3 * left * left - value * 2 * q) / over;
  return {value, slope, (6 * left - 2 * value - 4 * q * slope) / over};
}

}  // namespace

struct DeepStates::Record {
  SurfacePlace place;
  Vec3 x = Vec3::Zero(), normal = Vec3::Zero();
  Mat3 back = Mat3::Identity();  // B_k^-1
  double scale = 1;              // c_k^2
  double reach = 0;              // [m]
  double surprise = 0;
  int degree = 2;
  Series correction = Series::Zero();  // P_k
  std::vector<NodeDistance> ways;
};

// One state or jet, as it is seen from (s, x).
struct DeepStates::Seen {
  // By the place alone: q, its derivative by s, the cut along the way, and y = to_state x.
  double site_q = 0, cut = 1;
  Vec3 site_q_by = Vec3::Zero(), cut_by = Vec3::Zero();
  Mat3 turn = Mat3::Zero(), to_state = Mat3::Zero();
  // By s and x.
  Value weight, correction;  // p_k and C_k, with their derivatives by x
  Vec3 weight_by = Vec3::Zero(), correction_by = Vec3::Zero();
};

// The weighted sums over states, with their derivatives by x and s.
struct DeepStates::Sums {
  Value weights, values;
  Vec3 weights_by = Vec3::Zero(), values_by = Vec3::Zero();
  Vec3 mean = Vec3::Zero();  // sum of p_k times the correction of the force
  double square = 0;
};

DeepStates::DeepStates(std::shared_ptr<const SiteField> field, const DeepOptions& options,
                       std::shared_ptr<const FieldPatches> patches)
    : field_(std::move(field)), patches_(std::move(patches)), options_(options) {
  const SurfaceMap& map = field_->rest().map();
  const double radius = field_->rest().pad().radius();
  ways_ = std::make_shared<const EdgeDistances>(map);
  reach_ = options.site_reach * radius;
  rest_reach_ = options.rest_reach * field_->options().spacing;
  length_ = normal_length * radius;
  double edge = 0;
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
    edge = std::max({edge, (b - a).norm(), (c - b).norm(), (a - c).norm()});
  }
  far_ = 2 * std::max(reach_, rest_reach_) + edge;
}

SiteModel DeepStates::model(const SurfacePlace& place) const {
  if (!patches_ || !patches_->has(place.facet)) return field_->at(place, false);
  SiteModel model;
  patches_->fill(place, true, model);
  return model;
}

const SurfacePlace& DeepStates::place(std::size_t k) const {
  return records_[k]->place;
}
const Vec3& DeepStates::displacement(std::size_t k) const {
  return records_[k]->x;
}
double DeepStates::surprise(std::size_t k) const {
  return records_[k]->surprise;
}

std::shared_ptr<const DeepStates::Record> DeepStates::record_of(const State& state) const {
  const bool at_rest = state.at.isZero();
  if (!state.usable() || !state.has_site() || !state.has_stiffness() || (at_rest && !state.jet) ||
      !(at_rest || std::isfinite(state.energy)))
    return {};
  for (std::size_t i = 0; at_rest && !patches_ && i < field_->size(); ++i)
    if ((field_->place(i).at - state.site).norm() < same_place) return {};
  auto record = std::make_shared<Record>();
  record->place = field_->rest().map().nearest(state.site);
  if (field_->rest().map().facet(record->place).clamped) return {};
  record->x = state.at;
  record->degree = state.jet ? state.jet->order + 1 : 2;
  const SiteModel model = this->model(record->place);
  record->normal = model.rest().normal;
  const JetCoefficients jet =
      state.jet ? coefficients_of(*state.jet) : JetCoefficients(JetCoefficients::Zero());
  if (at_rest) {
    record->correction =
        series_of(0, Vec3::Zero(), patches_ ? Mat3(state.stiffness - model.rest().stiffness) : Mat3::Zero(),
                  jet - model.polynomial());
  } else {
    const Rest rest = before(model, record->place);
    const Series known = series_of(state.energy, state.force, state.stiffness, jet),
                 so_far = moved(series_of(0, Vec3::Zero(), rest.stiffness, rest.coefficients), state.at);
    record->correction = product(known - so_far, inverse_growth(state.at));
    record->surprise = (known - so_far).segment<3>(1).norm() / model.estimate(state.at);
    record->reach = std::min(options_.reach * state.at.norm(), series_radius(state.stiffness, jet)) /
                    std::sqrt(std::max(1.0, record->surprise));
  }
  record->correction.tail(static_cast<Eigen::Index>(series_size - start_of(record->degree + 1))).setZero();
  record->back = model.root().inverse();
  record->scale = model.scale();
  record->ways = ways_->from(record->place, 2 * far_);
  return record;
}

void DeepStates::add(const State& state) {
  auto record = record_of(state);
  if (!record) return;
  lights_.push_back({record->place.at, record->normal, record->x.isZero() ? rest_reach_ : reach_});
  records_.push_back(std::move(record));
}

std::shared_ptr<const DeepStates> DeepStates::with(std::span<const State> states) const {
  auto more = std::make_shared<DeepStates>(*this);
  for (const bool at_rest : {true, false})
    for (const State& state : states)
      if (state.at.isZero() == at_rest) more->add(state);
  std::vector<double> surprises;
  for (const auto& record : more->records_)
    if (!record->x.isZero()) surprises.push_back(record->surprise);
  if (surprises.empty()) return more;
  const auto at = surprises.begin() +
                  static_cast<std::ptrdiff_t>(surprise_quantile * static_cast<double>(surprises.size() - 1));
  std::ranges::nth_element(surprises, at);
  more->usual_surprise_ = std::max(least_surprise, *at);
  return more;
}

// Of field and jets at rest.
DeepStates::Rest DeepStates::before(const SiteModel& model, const SurfacePlace& place) const {
  double weights = options_.rest_weight;
  Rest sum;
  for (std::size_t k = 0; k < records_.size(); ++k) {
    Seen seen;
    if (!records_[k]->x.isZero() || !nearby(model, place, k, seen)) continue;
    const double weight = weight_of(seen.site_q).value * seen.cut;
    weights += weight;
    const double share = weight * model.scale() / records_[k]->scale;
    sum.stiffness += share * seen.to_state.transpose() *
                     value_of(records_[k]->correction, Vec3::Zero(), 2).bend * seen.to_state;
    sum.coefficients +=
        share * substituted(records_[k]->correction.tail<static_cast<int>(jet_size)>(), seen.to_state);
  }
  return {model.rest().stiffness + sum.stiffness / weights, model.polynomial() + sum.coefficients / weights};
}

// Sets what depends on the place alone; false where it is too far away.
bool DeepStates::nearby(const SiteModel& model, const SurfacePlace& place, std::size_t k, Seen& seen) const {
  const Light& light = lights_[k];
  const Vec3 &normal = model.rest().normal, away = place.at - light.at;
  const double far = light.reach * light.reach, bent = length_ * length_;
  seen.site_q = (away.squaredNorm() + bent * (normal - light.normal).squaredNorm()) / far;
  if (!(seen.site_q < 1)) return false;
  const Record& record = *records_[k];
  const SurfaceMap& map = field_->rest().map();
  const Triangle& corner = map.facet(place).corners;
  Vec3 way;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = std::ranges::lower_bound(record.ways, corner[i], {}, &NodeDistance::node);
    way[static_cast<int>(i)] = at != record.ways.end() && at->node == corner[i] ? at->distance : 2 * far_;
  }
  const double late = (map.barycentric(place).dot(way) - far_) / far_;
  seen.cut = fade(late);
  seen.turn = least_turn(normal, light.normal);
  seen.to_state = record.back * seen.turn * model.root();
  if (!model.has_slopes()) return seen.cut > 0;
  seen.site_q_by = 2 / far * (away + bent * model.rest().normal_by.transpose() * (normal - light.normal));
  const std::array<Vec3, 3> share_by = barycentric_slopes(map, place.facet);
  seen.cut_by =
      fade_slope(late) / far_ * (way[0] * share_by[0] + way[1] * share_by[1] + way[2] * share_by[2]);
  return seen.cut > 0;
}

bool DeepStates::see(const SiteModel& model, const SurfacePlace& place, const Vec3& x, std::size_t k,
                     Seen& seen) const {
  if (!nearby(model, place, k, seen)) return false;
  const Record& record = *records_[k];
  const Mat3& to_state = seen.to_state;
  const bool at_rest = record.x.isZero();
  const Vec3 y = to_state * x, d = y - record.x;
  const double near = at_rest ? 0 : 1 / (record.reach * record.reach),
               q = seen.site_q + near * d.squaredNorm();
  if (!(q < 1)) return false;
  const Weight core = weight_of(q);
  const Vec3 q_slope = 2 * near * (to_state.transpose() * d);
  seen.weight = {seen.cut * core.value, seen.cut * core.slope * q_slope,
                 seen.cut * (core.bend * q_slope * q_slope.transpose() +
                             2 * near * core.slope * to_state.transpose() * to_state)};
  const double scale = model.scale() / record.scale;
  Value at_state = value_of(record.correction, d, record.degree);
  if (!at_rest) at_state = times(growth(y, record.x.squaredNorm()), at_state);
  seen.correction = {scale * at_state.value, scale * (to_state.transpose() * at_state.slope),
                     scale * (to_state.transpose() * at_state.bend * to_state)};
  if (!model.has_slopes()) return true;
  Vec3 q_by = seen.site_q_by;
  seen.correction_by = model.scale_by() / record.scale * at_state.value;
  for (int i = 0; i < 3; ++i) {
    const Mat3 turn_by = least_turn_by(model.rest().normal, lights_[k].normal, model.rest().normal_by.col(i));
    const Vec3 y_by =
        record.back * (turn_by * model.root() + seen.turn * model.root_by()[static_cast<std::size_t>(i)]) * x;
    q_by[i] += 2 * near * d.dot(y_by);
    seen.correction_by[i] += scale * at_state.slope.dot(y_by);
  }
  seen.weight_by = seen.cut * core.slope * q_by + core.value * seen.cut_by;
  return true;
}

std::array<DeepStates::Sums, 2> DeepStates::sums(const SiteModel& model, const SurfacePlace& place,
                                                 const Vec3& x, std::span<const double> gains) const {
  std::array<Sums, 2> both;
  both[0].weights.value = options_.rest_weight, both[1].weights.value = options_.field_weight;
  for (std::size_t k = 0; k < records_.size(); ++k) {
    const double gain = k < gains.size() ? gains[k] : 1;
    Seen seen;
    if (!(gain > 0) || !see(model, place, x, k, seen)) continue;
    Sums& all = both[records_[k]->x.isZero() ? 0 : 1];
    const Value weight{gain * seen.weight.value, gain * seen.weight.slope, gain * seen.weight.bend},
        value = times(weight, seen.correction);
    all.weights.value += weight.value;
    all.weights.slope += weight.slope, all.weights.bend += weight.bend;
    all.weights_by += gain * seen.weight_by;
    all.values.value += value.value;
    all.values.slope += value.slope, all.values.bend += value.bend;
    all.values_by += weight.value * seen.correction_by + gain * seen.correction.value * seen.weight_by;
    all.mean -= weight.value * seen.correction.slope;
    all.square += weight.value * seen.correction.slope.squaredNorm();
  }
  return both;
}

SiteTerms DeepStates::at(const SiteModel& model, const SurfacePlace& place, const Vec3& x,
                         std::span<const double> gains) const {
  SiteTerms terms = model.at(x);
  for (const Sums& all : sums(model, place, x, gains)) {
    const double weight = all.weights.value, energy = all.values.value / weight;
    const Vec3 slope = (all.values.slope - energy * all.weights.slope) / weight;
    const Mat3 mixed = slope * all.weights.slope.transpose();
    terms.energy += energy;
    terms.force -= slope;
    terms.stiffness += (all.values.bend - mixed - mixed.transpose() - energy * all.weights.bend) / weight;
    if (model.has_slopes()) terms.by_site += (all.values_by - energy * all.weights_by) / weight;
  }
  return terms;
}

double DeepStates::estimated_error(const SiteModel& model, const SurfacePlace& place, const Vec3& x,
                                   std::span<const double> gains) const {
  const auto [jets, states] = sums(model, place, x, gains);
  const double weight = states.weights.value;
  const Vec3 mean = states.mean / weight;
  const double spread = std::max(0.0, states.square / weight - mean.squaredNorm());
  const double alone = options_.field_weight / weight * usual_surprise_ * model.estimate(x);
  const double between = options_.rest_weight / jets.weights.value * model.spread(x);
  return std::sqrt(spread + alone * alone + between * between);
}

bool DeepStates::trusted(const SiteModel& model, const SurfacePlace& place, const Vec3& x, double tolerance,
                         double floor, std::span<const double> gains) const {
  return 3 * estimated_error(model, place, x, gains) <=
         tolerance * std::max(at(model, place, x, gains).force.norm(), floor);
}

}  // namespace forefeel
