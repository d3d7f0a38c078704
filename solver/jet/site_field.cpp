#include "solver/jet/site_field.hpp"

#include <omp.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "geometry/common/dense.hpp"
#include "solver/jet/site_cover.hpp"
#include "solver/jet/site_turns.hpp"

namespace forefeel {
namespace {

constexpr double softening = 0.01;     // of the weights, in q
constexpr double ways_over_reach = 2;  // from where on the way along the surface counts as much longer

double scale_of(const Mat3& stiffness, double theta) {
  return std::pow(stiffness.determinant(), theta / 6);
}

Mat3 root_of(const Mat3& stiffness, double theta) {
  return square_root_of(stiffness) / scale_of(stiffness, theta);
}

Mat3 axes_across(const Vec3& normal) {
  Mat3 axes;
  axes.row(0) = normal.unitOrthogonal();
  axes.row(1) = normal.cross(axes.row(0).transpose());
  axes.row(2) = normal;
  return axes;
}

using Basis = Eigen::Matrix<double, 5, 1>;

Basis basis_at(double p, double q) {
  return Basis{p, q, p * p, p * q, q * q};
}

}  // namespace

// ---- the model at one site

// B, c^2 and their derivatives: S = K^(1/2) has S S_k + S_k S = K_k.
void SiteModel::set_root(double theta) {
  const Modes3 own = axes_of(rest_.stiffness);
  const Vec3 sigma = own.values.cwiseMax(1e-300).cwiseSqrt();
  const Mat3& v = own.vectors;
  const Mat3 root = v * sigma.asDiagonal() * v.transpose();
  const double c = scale_of(rest_.stiffness, theta);
  root_ = root / c;
  scale_ = c * c;
  if (!slopes_) return;
  const Mat3 inverse = rest_.stiffness.inverse();
  for (int k = 0; k < 3; ++k) {
    const Mat3& by = rest_.stiffness_by[static_cast<std::size_t>(k)];
    Mat3 turned = v.transpose() * by * v;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turned(i, j) /= sigma[i] + sigma[j];
    const double log_by = theta / 6 * (inverse * by).trace();  // of c
    root_by_[static_cast<std::size_t>(k)] = v * turned * v.transpose() / c - log_by * root_;
    scale_by_[k] = 2 * log_by * scale_;
  }
}

SiteTerms SiteModel::at(const Vec3& x, int degree) const {
  SiteTerms terms;
  terms.stiffness = rest_.stiffness;
  terms.force = -rest_.stiffness * x;
  terms.energy = -0.5 * x.dot(terms.force);
  for (int k = 0; k < 3 && slopes_; ++k)
    terms.by_site[k] = 0.5 * x.dot(rest_.stiffness_by[static_cast<std::size_t>(k)] * x);
  const auto count = static_cast<Eigen::Index>(jet_terms_of_order(degree - 1));
  if (count == 0) return terms;
  if (is_whole_) {
    const JetMonomials monomials = jet_monomials(x);
    const JetTerms sum = jet_sum(whole_, monomials, degree);
    terms.energy += sum.energy, terms.force -= sum.gradient, terms.stiffness += sum.hessian;
    terms.by_site += whole_by_.topRows(count).transpose() * monomials.value.head(count);
    return terms;
  }
  for (const Part& part : parts_) {
    const Mat3 to_part = part.turn * root_;
    const JetMonomials monomials = jet_monomials(to_part * x);
    const JetTerms sum = jet_sum(part.coefficients, monomials, degree);
    const double share = scale_ * part.weight;
    terms.energy += share * sum.energy;
    terms.force -= share * (to_part.transpose() * sum.gradient);
    terms.stiffness += share * (to_part.transpose() * sum.hessian * to_part);
    if (!slopes_) continue;
    terms.by_site += (scale_by_ * part.weight + scale_ * part.weight_by) * sum.energy +
                     share * (part.coefficients_by.topRows(count).transpose() * monomials.value.head(count));
    for (std::size_t k = 0; k < 3; ++k)
      terms.by_site[static_cast<int>(k)] +=
          share * sum.gradient.dot((part.turn_by[k] * root_ + part.turn * root_by_[k]) * x);
  }
  return terms;
}

void SiteModel::take(const SurfaceMap::OnFacet& where, const SiteRest& rest,
                     const JetCoefficients& polynomial, const JetGradient& polynomial_by, bool root,
                     double theta) {
  where_ = where, rest_ = rest;
  whole_ = polynomial, whole_by_ = polynomial_by;
  is_whole_ = slopes_ = true;
  parts_.clear();
  if (root) set_root(theta);
}

JetCoefficients SiteModel::polynomial() const {
  if (is_whole_) return whole_;
  JetCoefficients sum = JetCoefficients::Zero();
  for (const Part& part : parts_)
    sum += scale_ * part.weight * substituted(part.coefficients, part.turn * root_);
  return sum;
}

double SiteModel::estimate(const Vec3& x) const {
  Vec3 fourth = Vec3::Zero(), fifth = Vec3::Zero();  // the degrees' parts of -f
  if (is_whole_) {
    const JetMonomials at = jet_monomials(x);
    fourth = at.gradient.middleRows<15>(10).transpose() * whole_.segment<15>(10);
    fifth = at.gradient.bottomRows<21>().transpose() * whole_.tail<21>();
  }
  for (const Part& part : parts_) {
    const Mat3 to_part = part.turn * root_;
    const JetMonomials at = jet_monomials(to_part * x);
    const Mat3 back = scale_ * part.weight * to_part.transpose();
    fourth += back * (at.gradient.middleRows<15>(10).transpose() * part.coefficients.segment<15>(10));
    fifth += back * (at.gradient.bottomRows<21>().transpose() * part.coefficients.tail<21>());
  }
  return std::sqrt(fifth.squaredNorm() + 0.25 * fourth.squaredNorm() + 1e-12);
}

double SiteModel::spread(const Vec3& x) const {
  if (is_whole_) return 0;  // the neighbours are not known
  Vec3 mean = Vec3::Zero();
  double square = 0;
  for (const Part& part : parts_) {
    const Mat3 to_part = part.turn * root_;
    const JetMonomials at = jet_monomials(to_part * x);
    const Vec3 force = scale_ * to_part.transpose() * (at.gradient.transpose() * part.coefficients);
    mean += part.weight * force;
    square += part.weight * force.squaredNorm();
  }
  return std::sqrt(std::max(0.0, square - mean.squaredNorm()));
}

// ---- the field

SiteField::SiteField(std::shared_ptr<const RestSites> sites, const SiteFieldOptions& options,
                     const std::function<void(double)>& progress, const std::stop_token& stop,
                     KeptPieces* kept)
    : rest_(std::move(sites)), options_(options), length_(normal_length * rest_->pad().radius()) {
  for (const SurfacePlace& place :
       cover(rest_->map(), rest_->pad(), options.first, {.spacing = options.spacing}))
    sites_.emplace_back().place = place;
  make_jets(progress, stop, kept);
  connect();
}

SiteField::SiteField(std::shared_ptr<const RestSites> sites, const SiteFieldOptions& options,
                     const std::vector<FieldSite>& known)
    : rest_(std::move(sites)), options_(options), length_(normal_length * rest_->pad().radius()) {
  for (const FieldSite& site : known) static_cast<FieldSite&>(sites_.emplace_back()) = site;
  connect();
}

void SiteField::connect() {
  for (Site& site : sites_) site.axes = axes_across(site.normal);
  find_near();
#pragma omp parallel for schedule(dynamic) num_threads(options_.threads)
  for (std::size_t i = 0; i < sites_.size(); ++i) follow_neighbours(i);
}

void SiteField::make_jet(SiteJets& jets, Site& site) const {
  const RestJet jet = jets.at(site.place);
  site.stiffness = jet.stiffness;
  site.normal = rest_->pad().normal(site.place);
  const double c = scale_of(site.stiffness, options_.theta);
  site.own =
      substituted(coefficients_of(jet.jet), root_of(site.stiffness, options_.theta).inverse()) / (c * c);
}

namespace {

// What is kept of a site, by its number; the pieces below are those of the compliance.
constexpr std::uint64_t first_jet_piece = std::uint64_t{1} << 40;
using JetPiece = std::array<double, 9 + 3 + jet_size>;

JetPiece piece_of(const FieldSite& site) {
  JetPiece piece;
  double* out = std::copy_n(site.stiffness.data(), 9, piece.data());
  out = std::copy_n(site.normal.data(), 3, out);
  std::copy_n(site.own.data(), jet_size, out);
  return piece;
}

void take_piece(const JetPiece& piece, FieldSite& site) {
  std::copy_n(piece.data(), 9, site.stiffness.data());
  std::copy_n(piece.data() + 9, 3, site.normal.data());
  std::copy_n(piece.data() + 12, jet_size, site.own.data());
}

}  // namespace

void SiteField::make_jets(const std::function<void(double)>& progress, const std::stop_token& stop,
                          KeptPieces* kept) {
  std::vector<char> made(sites_.size(), 0);
  JetPiece piece{};
  for (std::size_t i = 0; i < sites_.size() && kept; ++i)
    if (kept->take(first_jet_piece + i, piece)) take_piece(piece, sites_[i]), made[i] = 1;
  auto done = static_cast<std::size_t>(std::ranges::count(made, 1));
  const auto show = [&] {
    if (progress) progress(static_cast<double>(done) / static_cast<double>(sites_.size()));
  };
  show();
#pragma omp parallel num_threads(options_.threads)
  {
    SiteJets jets(*rest_);
#pragma omp for schedule(dynamic)
    for (std::size_t i = 0; i < sites_.size(); ++i) {
      if (made[i] != 0 || stop.stop_requested()) continue;
      make_jet(jets, sites_[i]);
      made[i] = 1;
#pragma omp critical
      {
        if (kept) kept->keep(first_jet_piece + i, piece_of(sites_[i]));
        ++done;
        show();
      }
    }
  }
  std::vector<Site> all;
  for (std::size_t i = 0; i < sites_.size(); ++i)
    if (made[i] != 0) all.push_back(std::move(sites_[i]));
  sites_ = std::move(all);
}

EnergyJet SiteField::jet_of(const FieldSite& site) const {
  const double c = scale_of(site.stiffness, options_.theta);
  const JetCoefficients e = c * c * substituted(site.own, root_of(site.stiffness, options_.theta));
  EnergyJet jet{.order = most_jet_order};
  for (std::size_t i = 0; i < jet_size; ++i) jet.coefficients[i] = e[static_cast<Eigen::Index>(i)];
  return jet;
}

void SiteField::find_near() {
  double edge = 0;
  NodeIndex most = 0;
  for (std::size_t f = 0; f < rest_->map().facets().size(); ++f) {
    const auto [a, b, c] = rest_->map().corners(static_cast<std::int32_t>(f));
    edge = std::max({edge, (b - a).norm(), (c - b).norm(), (a - c).norm()});
    most = std::max(most, std::ranges::max(rest_->map().facets()[f].corners));
  }
  longest_way_ = 2 * ways_over_reach * options_.reach * options_.spacing + 2 * edge;
  near_.assign(std::size_t{most} + 1, {});
  const EdgeDistances ways(rest_->map());
  for (std::size_t i = 0; i < sites_.size(); ++i)
    for (const NodeDistance& node : ways.from(sites_[i].place, longest_way_))
      near_[node.node].push_back({static_cast<std::int32_t>(i), node.distance});
}

double SiteField::squared_delta(const Site& site, const Vec3& at, const Vec3& normal) const {
  return (at - site.place.at).squaredNorm() + length_ * length_ * (normal - site.normal).squaredNorm();
}

// Coefficients at the neighbours, in this site's frame, by least squares; one's own value stays.
void SiteField::follow_neighbours(std::size_t i) {
  Site& site = sites_[i];
  const double reach = options_.fitted * options_.spacing;
  std::vector<std::size_t> neighbours;
  for (const Near& near : near_[rest_->map().facet(site.place).corners[0]]) {
    const auto j = static_cast<std::size_t>(near.site);
    if (j != i && squared_delta(site, sites_[j].place.at, sites_[j].normal) < reach * reach)
      neighbours.push_back(j);
  }
  const int degree = neighbours.size() >= 8   ? options_.degree
                     : neighbours.size() >= 4 ? std::min(1, options_.degree)
                                              : 0;
  if (degree == 0) return;
  const Eigen::Index terms = degree == 1 ? 2 : 5, rows = static_cast<Eigen::Index>(neighbours.size());
  Eigen::MatrixXd a(rows, terms), b(rows, static_cast<Eigen::Index>(jet_size));
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Site& other = sites_[neighbours[static_cast<std::size_t>(k)]];
    const Vec3 p = site.axes * (other.place.at - site.place.at) / options_.spacing;
    const double q = squared_delta(site, other.place.at, other.normal) / (reach * reach);
    const double weight = (1 - q) / (std::sqrt(q) + 0.1);
    const JetCoefficients seen = substituted(other.own, least_turn(site.normal, other.normal));
    a.row(k) = weight * basis_at(p[0], p[1]).head(terms).transpose();
    b.row(k) = weight * (seen - site.own).transpose();
  }
  const double ridge = 1e-3 * std::sqrt(a.squaredNorm() / static_cast<double>(terms));
  Eigen::MatrixXd stacked(rows + terms, terms), values = Eigen::MatrixXd::Zero(rows + terms, b.cols());
  stacked << a, ridge * Eigen::MatrixXd::Identity(terms, terms);
  values.topRows(rows) = b;
  site.slopes.leftCols(terms) = least_squares(stacked, values).transpose();
}

void SiteField::add_parts(const SurfacePlace& place, const SiteRest& rest, SiteModel& model) const {
  const Triangle& corner = rest_->map().facet(place).corners;
  const Vec3& share = model.where_.share;
  // Over the way along the surface, interpolated from the corners.
  const std::array<Vec3, 3>& by = model.where_.by;
  const double reach = options_.reach * options_.spacing;
  double sum = 0;
  Vec3 sum_by = Vec3::Zero();
  std::vector<std::int32_t> candidates;
  for (const NodeIndex node : corner)
    for (const Near& near : near_[node]) candidates.push_back(near.site);
  std::ranges::sort(candidates);
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  for (const std::int32_t number : candidates) {
    const Site& site = sites_[static_cast<std::size_t>(number)];
    const double q = squared_delta(site, place.at, rest.normal) / (reach * reach);
    if (q >= 1) continue;
    double way = 0;
    Vec3 way_by = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& list = near_[corner[i]];
      const auto at = std::ranges::lower_bound(list, number, {}, &Near::site);
      const double its = at != list.end() && at->site == number ? at->way : longest_way_;
      way += share[static_cast<int>(i)] * its, way_by += by[i] * its;
    }
    const double far = longest_way_ / 2, late = (way - far) / far;
    const double core = std::pow(1 - q, 3) / ((q + softening) * (q + softening));
    SiteModel::Part part;
    part.weight = core * fade(late);
    if (!(part.weight > 0)) continue;
    const Vec3 q_by = 2 / (reach * reach) *
                      (place.at - site.place.at +
                       length_ * length_ * rest.normal_by.transpose() * (rest.normal - site.normal));
    part.weight_by = core * (-3 / (1 - q) - 2 / (q + softening)) * fade(late) * q_by +
                     core * fade_slope(late) / far * way_by;
    const Vec3 p = site.axes * (place.at - site.place.at) / options_.spacing;
    part.coefficients = site.own + site.slopes * basis_at(p[0], p[1]);
    part.turn = least_turn(rest.normal, site.normal);
    if (model.slopes_) {
      Eigen::Matrix<double, 5, 2> basis_by;
      basis_by << 1, 0, 0, 1, 2 * p[0], 0, p[1], p[0], 0, 2 * p[1];
      part.coefficients_by = site.slopes * basis_by * site.axes.topRows<2>() / options_.spacing;
      for (std::size_t k = 0; k < 3; ++k)
        part.turn_by[k] = least_turn_by(rest.normal, site.normal, rest.normal_by.col(static_cast<int>(k)));
    }
    sum += part.weight, sum_by += part.weight_by;
    model.parts_.push_back(part);
  }
  for (SiteModel::Part& part : model.parts_) {
    part.weight /= sum;
    part.weight_by = (part.weight_by - part.weight * sum_by) / sum;
  }
}

SiteModel SiteField::at(const SurfacePlace& place, bool slopes) const {
  SiteModel model;
  model.slopes_ = slopes;
  model.where_ = rest_->map().on_facet(place);
  model.rest_ = rest_->at(place, slopes);
  model.set_root(options_.theta);
  add_parts(place, model.rest_, model);
  return model;
}

}  // namespace forefeel
