#include "solver/jet/deep_states.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "solver/jet/field_patches.hpp"
#include "solver/jet/site_turns.hpp"
#include "solver/jet/state_series.hpp"

namespace forefeel {
namespace {

constexpr double same_place = 1e-9;        // [m]
constexpr double least_square = 1e-12;     // q^2 at a state, where the weight would be infinite
constexpr double least_surprise = 1;       // of the field, until states say more
constexpr double surprise_quantile = 0.8;  // of the states' that counts for other places

// (z^T M z / square)^3.
Smooth growth(const Vec3& z, const Mat3& metric, double square, bool bend) {
  const Vec3 by = 2 / square * (metric * z);
  const double r = 0.5 * z.dot(by);
  Smooth g{r * r * r, 3 * r * r * by};
  if (bend) g.bend = 6 * r * (r / square * metric + by * by.transpose());
  return g;
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

// In z = Q_k B x, so that y = B_k^-1 z.
struct DeepStates::Record {
  Vec3 normal = Vec3::Zero();
  double square = 0;  // reach_r^2 or reach_s^2
  SurfacePlace place;
  Vec3 x = Vec3::Zero(), z = Vec3::Zero();
  Mat3 metric = Mat3::Zero();  // |y|^2 = z^T metric z
  double near = 0;             // 1 / reach_k^2; 0 at rest
  double surprise = 0;
  SeriesForm correction;  // P_k / c_k^2 in z - z_k
  bool at_rest = false;
};

// Where and what is asked.
struct DeepStates::Asked {
  const SiteModel& model;
  const SurfacePlace& place;
  Vec3 u = Vec3::Zero();  // B x
  bool bend = true;
  Vec3 share = Vec3::Zero();       // barycentric
  std::array<Vec3, 3> share_by{};  // by s
};

// One state or jet, as it is seen from (s, x): derivatives by u, by s where it stands alone, and by the normal.
struct DeepStates::Seen {
  LeastTurn turn;
  double site_q = 0, cut = 1;
  Vec3 away = Vec3::Zero(), cut_by = Vec3::Zero();
  Smooth weight, correction;  // p_k and C_k / c(s)^2
  Vec3 weight_by = Vec3::Zero(), weight_by_normal = Vec3::Zero(), correction_by_normal = Vec3::Zero();
};

// The weighted sums over states and their derivatives.
struct DeepStates::Sums {
  Smooth weights, values;
  Vec3 weights_by = Vec3::Zero(), values_by = Vec3::Zero();
  Vec3 weights_by_normal = Vec3::Zero(), values_by_normal = Vec3::Zero();
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
  near_.resize(map.facets().size());
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
  record->x = state.at, record->at_rest = at_rest;
  const int degree = state.jet ? state.jet->order + 1 : 2;
  const SiteModel model = this->model(record->place);
  record->normal = model.rest().normal;
  const double reach = at_rest ? rest_reach_ : reach_;
  record->square = reach * reach;
  record->z = model.root() * record->x;
  const Mat3 back = model.root().inverse();
  record->metric = back.transpose() * back;
  const JetCoefficients jet =
      state.jet ? coefficients_of(*state.jet) : JetCoefficients(JetCoefficients::Zero());
  Series correction;
  if (at_rest) {
    correction =
        series_of(0, Vec3::Zero(), patches_ ? Mat3(state.stiffness - model.rest().stiffness) : Mat3::Zero(),
                  jet - model.polynomial());
  } else {
    const Rest rest = before(model, record->place);
    const Series known = series_of(state.energy, state.force, state.stiffness, jet),
                 so_far = moved(series_of(0, Vec3::Zero(), rest.stiffness, rest.coefficients), state.at);
    correction = product(known - so_far, inverse_growth(state.at));
    record->surprise = (known - so_far).segment<3>(1).norm() / model.estimate(state.at);
    const double deep = std::min(options_.reach * state.at.norm(), series_radius(state.stiffness, jet));
    record->near = std::max(1.0, record->surprise) / (deep * deep);
  }
  record->correction = SeriesForm(turned(cut_after(correction, degree), back) / model.scale());
  return record;
}

void DeepStates::add(const State& state, std::vector<bool>& own) {
  const auto record = record_of(state);
  if (!record) return;
  records_.push_back(record);
  const SurfaceMap& map = field_->rest().map();
  const std::vector<NodeDistance> ways = ways_->from(record->place, 2 * far_);
  const double reach = std::sqrt(record->square);
  for (std::size_t f = 0; f < near_.size(); ++f) {
    if (map.facets()[f].clamped) continue;
    const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
    const Vec3 middle = (a + b + c) / 3;
    const double round = std::sqrt(
        std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
    if ((middle - record->place.at).norm() > reach + round) continue;
    Near near{record.get(), Vec3::Constant(2 * far_)};
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex corner = map.facets()[f].corners[i];
      const auto at = std::ranges::lower_bound(ways, corner, {}, &NodeDistance::node);
      if (at != ways.end() && at->node == corner) near.way[static_cast<int>(i)] = at->distance;
    }
    if (near.way.minCoeff() >= 2 * far_) continue;
    if (!own[f])
      near_[f] =
          near_[f] ? std::make_shared<std::vector<Near>>(*near_[f]) : std::make_shared<std::vector<Near>>();
    own[f] = true;
    near_[f]->push_back(near);
  }
}

std::shared_ptr<const DeepStates> DeepStates::with(std::span<const State> states) const {
  auto more = std::make_shared<DeepStates>(*this);
  std::vector<bool> own(near_.size());
  for (const bool at_rest : {true, false})
    for (const State& state : states)
      if (state.at.isZero() == at_rest) more->add(state, own);
  std::vector<double> surprises;
  for (const auto& record : more->records_)
    if (!record->at_rest) surprises.push_back(record->surprise);
  if (surprises.empty()) return more;
  const auto at = surprises.begin() +
                  static_cast<std::ptrdiff_t>(surprise_quantile * static_cast<double>(surprises.size() - 1));
  std::ranges::nth_element(surprises, at);
  more->usual_surprise_ = std::max(least_surprise, *at);
  return more;
}

std::span<const DeepStates::Near> DeepStates::near(const SurfacePlace& place) const {
  const auto& list = near_[static_cast<std::size_t>(place.facet)];
  return list ? std::span<const Near>(*list) : std::span<const Near>();
}

// Of field and jets at rest.
DeepStates::Rest DeepStates::before(const SiteModel& model, const SurfacePlace& place) const {
  double weights = options_.rest_weight;
  Rest sum;
  const Asked asked{.model = model, .place = place, .share = field_->rest().map().barycentric(place)};
  for (const Near& near : near(place)) {
    Seen seen;
    if (!near.record->at_rest || !nearby(asked, near, seen)) continue;
    const double weight = weight_of(seen.site_q).value * seen.cut;
    weights += weight;
    const Series here = turned(near.record->correction.series(),
                               least_turn(model.rest().normal, near.record->normal) * model.root());
    const Smooth bent = SeriesForm(here).at(Vec3::Zero(), true);
    sum.stiffness += weight * model.scale() * bent.bend;
    sum.coefficients += weight * model.scale() * here.tail<static_cast<int>(jet_size)>();
  }
  return {model.rest().stiffness + sum.stiffness / weights, model.polynomial() + sum.coefficients / weights};
}

// Sets what depends on the place alone; false where it is too far away.
bool DeepStates::nearby(const Asked& asked, const Near& near, Seen& seen) const {
  const Record& record = *near.record;
  const Vec3& normal = asked.model.rest().normal;
  seen.away = asked.place.at - record.place.at;
  seen.site_q =
      (seen.away.squaredNorm() + length_ * length_ * (normal - record.normal).squaredNorm()) / record.square;
  if (!(seen.site_q < 1)) return false;
  const double late = (asked.share.dot(near.way) - far_) / far_;
  seen.cut = fade(late);
  if (!(seen.cut > 0)) return false;
  if (late > 0)
    seen.cut_by =
        fade_slope(late) / far_ *
        (near.way[0] * asked.share_by[0] + near.way[1] * asked.share_by[1] + near.way[2] * asked.share_by[2]);
  return true;
}

bool DeepStates::see(const Asked& asked, const Near& near, Seen& seen) const {
  if (!nearby(asked, near, seen)) return false;
  const Record& record = *near.record;
  const Vec3& normal = asked.model.rest().normal;
  seen.turn = LeastTurn(normal, record.normal);
  const Vec3 z = seen.turn.of(asked.u), d = z - record.z, bent = record.metric * d;
  const double q = seen.site_q + record.near * d.dot(bent);
  if (!(q < 1)) return false;
  const Weight core = weight_of(q);
  const Vec3 by_z = 2 * record.near * bent;  // of q
  Smooth at_z = record.correction.at(d, asked.bend);
  if (!record.at_rest)
    at_z = times(growth(z, record.metric, record.x.squaredNorm(), asked.bend), at_z, asked.bend);
  const Vec3 q_slope = seen.turn.back(by_z);
  seen.weight.value = seen.cut * core.value, seen.weight.slope = seen.cut * core.slope * q_slope;
  seen.correction.value = at_z.value, seen.correction.slope = seen.turn.back(at_z.slope);
  if (asked.bend) {
    const Mat3 turn = least_turn(normal, record.normal);
    seen.weight.bend = seen.cut * (core.bend * q_slope * q_slope.transpose() +
                                   2 * record.near * core.slope * turn.transpose() * record.metric * turn);
    seen.correction.bend = turn.transpose() * at_z.bend * turn;
  }
  if (!asked.model.has_slopes()) return true;
  const double by_q = seen.cut * core.slope;
  seen.weight_by = 2 * by_q / record.square * seen.away + core.value * seen.cut_by;
  seen.weight_by_normal = 2 * by_q * length_ * length_ / record.square * (normal - record.normal);
  if (!record.at_rest) seen.weight_by_normal += by_q * seen.turn.by_normal(by_z, asked.u);
  seen.correction_by_normal = seen.turn.by_normal(at_z.slope, asked.u);
  return true;
}

std::array<DeepStates::Sums, 2> DeepStates::sums(const SiteModel& model, const SurfacePlace& place,
                                                 const Vec3& x, bool bend) const {
  const SurfaceMap& map = field_->rest().map();
  Asked asked{
      .model = model, .place = place, .u = model.root() * x, .bend = bend, .share = map.barycentric(place)};
  if (model.has_slopes()) asked.share_by = barycentric_slopes(map, place.facet);
  std::array<Sums, 2> both;
  both[0].weights.value = options_.rest_weight, both[1].weights.value = options_.field_weight;
  for (const Near& near : near(place)) {
    Seen seen;
    if (!see(asked, near, seen)) continue;
    Sums& all = both[near.record->at_rest ? 0 : 1];
    const Smooth value = times(seen.weight, seen.correction, bend);
    all.weights.value += seen.weight.value, all.weights.slope += seen.weight.slope;
    all.values.value += value.value, all.values.slope += value.slope;
    if (bend) all.weights.bend += seen.weight.bend, all.values.bend += value.bend;
    const Vec3 force = model.scale() * (model.root() * seen.correction.slope);
    all.mean -= seen.weight.value * force;
    all.square += seen.weight.value * force.squaredNorm();
    if (!model.has_slopes()) continue;
    all.weights_by += seen.weight_by, all.weights_by_normal += seen.weight_by_normal;
    all.values_by += seen.correction.value * seen.weight_by;
    all.values_by_normal +=
        seen.weight.value * seen.correction_by_normal + seen.correction.value * seen.weight_by_normal;
  }
  return both;
}

SiteTerms DeepStates::at(const SiteModel& model, const SurfacePlace& place, const Vec3& x, bool stiff) const {
  SiteTerms terms = model.at(x);
  for (const Sums& all : sums(model, place, x, stiff)) {
    const double weight = all.weights.value, mean = all.values.value / weight, scale = model.scale();
    const Vec3 slope = (all.values.slope - mean * all.weights.slope) / weight;
    terms.energy += scale * mean;
    terms.force -= scale * (model.root() * slope);
    if (stiff) {
      const Mat3 mixed = slope * all.weights.slope.transpose();
      terms.stiffness += scale / weight * model.root() *
                         (all.values.bend - mixed - mixed.transpose() - mean * all.weights.bend) *
                         model.root();
    }
    if (!model.has_slopes()) continue;
    terms.by_site += scale / weight * (all.values_by - mean * all.weights_by) + mean * model.scale_by() +
                     scale / weight * model.rest().normal_by.transpose() *
                         (all.values_by_normal - mean * all.weights_by_normal);
    for (int i = 0; i < 3; ++i)
      terms.by_site[i] += scale * slope.dot(model.root_by()[static_cast<std::size_t>(i)] * x);
  }
  return terms;
}

double DeepStates::estimated_error(const SiteModel& model, const SurfacePlace& place, const Vec3& x) const {
  const auto [jets, states] = sums(model, place, x, false);
  const double weight = states.weights.value;
  const Vec3 mean = states.mean / weight;
  const double spread = std::max(0.0, states.square / weight - mean.squaredNorm());
  const double alone = options_.field_weight / weight * usual_surprise_ * model.estimate(x);
  const double between = options_.rest_weight / jets.weights.value * model.spread(x);
  return std::sqrt(spread + alone * alone + between * between);
}

bool DeepStates::trusted(const SiteModel& model, const SurfacePlace& place, const Vec3& x, double tolerance,
                         double floor) const {
  return 3 * estimated_error(model, place, x) <=
         tolerance * std::max(at(model, place, x, false).force.norm(), floor);
}

}  // namespace forefeel
