#include "solver/jet/deep_states.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/jet/field_patches.hpp"
#include "solver/jet/site_turns.hpp"
#include "solver/kernels/site_sums.hpp"

namespace forefeel {

namespace {

constexpr int start_of(int degree) {
  return degree * (degree + 1) * (degree + 2) / 6;
}
int place_of(int a, int b, int c) {
  const int left = b + c;
  return start_of(a + left) + left * (left + 1) / 2 + c;
}

template <class Visit>
void for_each_power(const Visit& visit) {
  for (int degree = 0; degree <= 5; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) visit(a, b, degree - a - b);
}

}  // namespace

Series product(const Series& p, const Series& q) {
  Series r = Series::Zero();
  for_each_power([&](int a, int b, int c) {
    const double left = p[place_of(a, b, c)];
    if (left == 0) return;
    for_each_power([&](int i, int j, int k) {
      if (a + b + c + i + j + k <= 5) r[place_of(a + i, b + j, c + k)] += left * q[place_of(i, j, k)];
    });
  });
  return r;
}

Series series_of(double e, const Vec3& f, const Mat3& k, const JetCoefficients& jet) {
  Series s;
  s << e, -f, 0.5 * k(0, 0), k(0, 1), k(0, 2), 0.5 * k(1, 1), k(1, 2), 0.5 * k(2, 2), jet;
  return s;
}

Series moved(const Series& p, const Vec3& x) {
  Series r = Series::Zero();
  constexpr double choose[6][6] = {{1},          {1, 1},          {1, 2, 1},
                                   {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}};
  for_each_power([&](int a, int b, int c) {
    const double value = p[place_of(a, b, c)];
    for (int i = 0; i <= a; ++i)
      for (int j = 0; j <= b; ++j)
        for (int k = 0; k <= c; ++k)
          r[place_of(i, j, k)] += value * choose[a][i] * choose[b][j] * choose[c][k] * std::pow(x[0], a - i) *
                                  std::pow(x[1], b - j) * std::pow(x[2], c - k);
  });
  return r;
}

Series turned(const Series& p, const Mat3& t) {
  return series_of(p[0], -t.transpose() * p.segment<3>(1), t.transpose() * stiffness_of(p) * t,
                   substituted(p.tail<static_cast<int>(jet_size)>(), t));
}

Series inverse_growth(const Vec3& x) {
  const double square = x.squaredNorm();
  const Series u = series_of(0, -2 * x / square, 2 * Mat3::Identity() / square, JetCoefficients::Zero());
  Series power = Series::Zero(), sum = Series::Zero();
  power[0] = 1;
  for (int n = 0; n <= 5; ++n, power = product(power, u))
    sum += (n % 2 == 0 ? 0.5 : -0.5) * (n + 1) * (n + 2) * power;
  return sum;
}

Series cut_after(const Series& p, int degree) {
  Series cut = p;
  cut.tail(series_size - start_of(degree + 1)).setZero();
  return cut;
}

Mat3 stiffness_of(const Series& p) {
  Mat3 k;
  k << 2 * p[4], p[5], p[6], p[5], 2 * p[7], p[8], p[6], p[8], 2 * p[9];
  return k;
}

namespace {

constexpr double same_place = 1e-9;        // [m]
constexpr double least_surprise = 1;       // of the field, until states say more
constexpr double surprise_quantile = 0.8;  // of the states' that counts for other places

// (1 - q)^3 / q^2.
double weight_of(double q) {
  const double left = 1 - q;
  return left * left * left / (q * q + site_softening);
}

Vec3 vec(const double* v) {
  return {v[0], v[1], v[2]};
}
Mat3 bend_of(const double* v) {
  Mat3 m;
  m << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  return m;
}
void put(const Vec3& from, double* to) {
  std::copy_n(from.data(), 3, to);
}

}  // namespace

struct DeepStates::Record {
  SurfacePlace place;
  Vec3 x = Vec3::Zero();
  double surprise = 0;
  SiteRow row;
  bool at_rest() const { return row.growth == 0; }
};

// A part of a facet's list: at most eight, then those that were known before.
struct DeepStates::Pack {
  SitePack sites;
  int count = 0;
  std::shared_ptr<const Pack> next;
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
  near_.resize(2 * map.facets().size());
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
  const int degree = state.jet ? state.jet->order + 1 : 2;
  const SiteModel model = this->model(record->place);
  const Mat3 back = model.root().inverse(), metric = back.transpose() * back;
  SiteRow& row = record->row;
  const double reach = at_rest ? rest_reach_ : reach_;
  put(record->place.at, row.at), put(model.rest().normal, row.normal), put(model.root() * record->x, row.z);
  row.reach = 1 / (reach * reach);
  for (int i = 0, k = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) row.metric[k++] = metric(i, j);
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
    row.near = std::max(1.0, record->surprise) / (deep * deep);
    row.growth = 1 / state.at.squaredNorm();
  }
  const Series in_z = turned(cut_after(correction, degree), back) / model.scale();
  std::copy_n(in_z.data(), series_terms, row.series);
  return record;
}

bool DeepStates::add(const State& state) {
  const auto record = record_of(state);
  if (!record) return false;
  records_.push_back(record);
  const SurfaceMap& map = field_->rest().map();
  const std::vector<NodeDistance> ways = ways_->from(record->place, 2 * far_);
  const double reach = record->at_rest() ? rest_reach_ : reach_;
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    if (map.facets()[f].clamped) continue;
    const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
    const Vec3 middle = (a + b + c) / 3;
    const double round = std::sqrt(
        std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
    if ((middle - record->place.at).norm() > reach + round) continue;
    Vec3 way = Vec3::Constant(2 * far_);
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex corner = map.facets()[f].corners[i];
      const auto at = std::ranges::lower_bound(ways, corner, {}, &NodeDistance::node);
      if (at != ways.end() && at->node == corner) way[static_cast<int>(i)] = at->distance;
    }
    if (way.minCoeff() < 2 * far_) list(*record, way, near_[2 * f + (record->at_rest() ? 0 : 1)]);
  }
  return true;
}

double DeepStates::score(const State& state) const {
  const SurfacePlace place = field_->rest().map().nearest(state.site);
  const SiteModel model = this->model(place);
  return (at(model, place, state.at, false).force - state.force).norm() /
         estimated_error(model, place, state.at);
}

void DeepStates::list(const Record& record, const Vec3& way, std::shared_ptr<const Pack>& first) {
  const bool full = !first || first->count == lane_count;
  const auto pack = full ? std::make_shared<Pack>() : std::make_shared<Pack>(*first);
  if (full) pack->next = first, pack->sites.next = first ? &first->sites : nullptr;
  for (int lane = pack->count++; lane < (full ? lane_count : pack->count);
       ++lane) {  // none behind it: out of reach
    const auto i = static_cast<std::size_t>(lane);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pack->sites.at[axis][i] = record.row.at[axis];
      pack->sites.normal[axis][i] = record.row.normal[axis];
      pack->sites.way[axis][i] = way[static_cast<int>(axis)];
    }
    pack->sites.reach[i] = lane < pack->count ? record.row.reach : std::numeric_limits<double>::infinity();
    pack->sites.row[i] = &record.row;
  }
  first = pack;
}

std::shared_ptr<const DeepStates> DeepStates::with(std::span<const State> states) const {
  auto more = std::make_shared<DeepStates>(*this);
  for (const bool at_rest : {true, false})
    for (const State& state : states)
      if (state.at.isZero() == at_rest && more->add(state) && !at_rest && patches_)
        more->scores_.push_back(score(state));
  std::vector<double> surprises;
  for (const auto& record : more->records_)
    if (!record->at_rest()) surprises.push_back(record->surprise);
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
  const Vec3& normal = model.rest().normal;
  const Vec3& share = model.where().share;
  for (const Pack* pack = near_[2 * static_cast<std::size_t>(place.facet)].get(); pack;
       pack = pack->next.get())
    for (int i = 0; i < pack->count; ++i) {
      const SiteRow& row = *pack->sites.row[i];
      const Vec3 way(pack->sites.way[0][i], pack->sites.way[1][i], pack->sites.way[2][i]);
      const double q = ((place.at - vec(row.at)).squaredNorm() +
                        length_ * length_ * (normal - vec(row.normal)).squaredNorm()) *
                       row.reach;
      if (!(q < 1)) continue;
      const double weight = weight_of(q) * fade((share.dot(way) - far_) / far_);
      weights += weight;
      const Series here =
          turned(Eigen::Map<const Series>(row.series), least_turn(normal, vec(row.normal)) * model.root());
      sum.stiffness += weight * model.scale() * stiffness_of(here);
      sum.coefficients += weight * model.scale() * here.tail<static_cast<int>(jet_size)>();
    }
  return {model.rest().stiffness + sum.stiffness / weights, model.polynomial() + sum.coefficients / weights};
}

// Of jets at rest and of states.
std::array<SiteSums, 2> DeepStates::sums(const SiteModel& model, const SurfacePlace& place, const Vec3& x,
                                         bool bend) const {
  SiteQuestion asked;
  put(place.at, asked.at), put(model.rest().normal, asked.normal), put(model.root() * x, asked.u);
  put(model.where().share, asked.share);
  for (std::size_t i = 0; i < 3; ++i) put(model.where().by[i], asked.share_by + 3 * i);
  std::copy_n(model.root().data(), 9, asked.root);  // symmetric
  asked.square = length_ * length_, asked.far = far_;
  std::array<SiteSums, 2> both;
  both[0].weights.value = options_.rest_weight, both[1].weights.value = options_.field_weight;
  const SiteKernels& kernels = site_kernels();
  for (std::size_t i = 0; i < 2; ++i)
    if (const Pack* first = near_[2 * static_cast<std::size_t>(place.facet) + i].get())
      (bend ? kernels.bends : kernels.slopes)(&first->sites, asked, both[i]);
  return both;
}

SiteTerms DeepStates::at(const SiteModel& model, const SurfacePlace& place, const Vec3& x, bool stiff) const {
  SiteTerms terms = model.at(x);
  for (const SiteSums& all : sums(model, place, x, stiff)) {
    const double weight = all.weights.value, mean = all.values.value / weight, share = model.scale() / weight;
    const Vec3 weights_u = vec(all.weights.by_u), slope = share * (vec(all.values.by_u) - mean * weights_u);
    terms.energy += model.scale() * mean;
    terms.force -= model.root() * slope;
    if (stiff) {
      const Mat3 mixed = slope * weights_u.transpose() / weight,
                 bend = share * (bend_of(all.values.bend) - mean * bend_of(all.weights.bend));
      terms.stiffness += model.root() * (bend - mixed - mixed.transpose()) * model.root();
    }
    if (!model.has_slopes()) continue;
    terms.by_site += share * (vec(all.values.by_site) - mean * vec(all.weights.by_site)) +
                     mean * model.scale_by() +
                     share * model.rest().normal_by.transpose() *
                         (vec(all.values.by_normal) - mean * vec(all.weights.by_normal));
    for (int i = 0; i < 3; ++i)
      terms.by_site[i] += slope.dot(model.root_by()[static_cast<std::size_t>(i)] * x);
  }
  return terms;
}

double DeepStates::estimated_error(const SiteModel& model, const SurfacePlace& place, const Vec3& x) const {
  const auto [jets, states] = sums(model, place, x, false);
  const double weight = states.weights.value, scale = model.scale();
  const Vec3 mean = scale / weight * (model.root() * vec(states.slope));
  const double spread = std::max(0.0, scale * scale * states.square / weight - mean.squaredNorm());
  const double alone = options_.field_weight / weight * usual_surprise_ * model.estimate(x);
  const double no_jet = options_.rest_weight / jets.weights.value, between = no_jet * model.spread(x),
               facets = patches_ ? no_jet * patches_->error() * (model.rest().stiffness * x).norm() : 0;
  return std::sqrt(spread + alone * alone + between * between + facets * facets);
}

bool DeepStates::trusted(const SiteModel& model, const SurfacePlace& place, const Vec3& x, double tolerance,
                         double floor) const {
  return 3 * estimated_error(model, place, x) <=
         tolerance * std::max(at(model, place, x, false).force.norm(), floor);
}

}  // namespace forefeel
