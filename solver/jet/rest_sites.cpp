#include "solver/jet/rest_sites.hpp"

#include <omp.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <vector>

#include "solver/jet/jet_maker.hpp"
#include "solver/jet/rest_jet.hpp"
#include "solver/system/factorisation.hpp"

namespace forefeel {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

Body without_contact(Body body) {
  body.pad.reset();
  body.contact.clear();
  body.fine.reset();
  return body;
}

// The pad at a site, the compliance of its nodes, and I + M C factorised. Rows by component, then node: c n + i.
struct Local {
  PadAt pad;
  MatrixXd compliance, tangent, pull;  // C, U and w
  Eigen::PartialPivLU<MatrixXd> system;

  Index size() const { return pad.springs.rows(); }
  // M b for columns by component.
  MatrixXd springs_times(const MatrixXd& b) const {
    MatrixXd product(b.rows(), b.cols());
    for (Index c = 0; c < 3; ++c)
      product.middleRows(c * size(), size()) = pad.springs * b.middleRows(c * size(), size());
    return product;
  }
};

}  // namespace

struct RestSites::Impl {
  std::shared_ptr<const Body> body;
  std::shared_ptr<const Discretisation> d;
  SurfaceMap map;
  std::vector<double> blocks;                   // of A_0
  std::vector<std::int32_t> local;              // of each surface node: its local node of d
  std::vector<std::vector<std::int32_t>> near;  // of each surface node: those that one pad may hold with it
  std::vector<std::vector<double>> compliance;  // near x 3 x 3, column by column [m/N]
  std::unique_ptr<MovingPad> pad;

  explicit Impl(std::shared_ptr<const Body> given)
      : body(std::move(given)), d(analyse(without_contact(*body))), map(*body) {
    blocks.assign(9 * static_cast<std::size_t>(d->pattern.size() + 1), 0.0);
    const std::vector<double> rest(static_cast<std::size_t>(d->local_size()), 0.0);
    d->elements.hessian(rest.data(), blocks.data());
    pad = std::make_unique<MovingPad>(map, body->pad->radius, body->pad->stiffness, number_nodes());
    find_near();
  }

  Factorisation factor() const {
    Factorisation made(*d);
    if (!made.compute(blocks.data())) throw InputError("body", "has no stable equilibrium at rest");
    return made;
  }

  FacetNodes number_nodes() {
    std::map<std::array<NodeIndex, 2>, std::size_t> middle;
    for (std::size_t e = 0; e < d->edges.size(); ++e) middle[d->edges[e]] = body->mesh.nodes.size() + e;
    FacetNodes nodes{.per_facet = d->edges.empty() ? 3 : 6, .of = {}};
    std::map<std::int32_t, std::int32_t> number;
    for (const SurfaceMap::Facet& facet : map.facets()) {
      nodes.of.push_back({-1, -1, -1, -1, -1, -1});
      for (std::size_t i = 0; i < static_cast<std::size_t>(nodes.per_facet); ++i) {
        const NodeIndex a = facet.corners[i % 3], b = facet.corners[(i + 1) % 3];
        const std::int32_t node = d->local[i < 3 ? a : middle.at({std::min(a, b), std::max(a, b)})];
        if (node >= d->free_nodes) continue;
        const auto [at, fresh] = number.try_emplace(node, static_cast<std::int32_t>(local.size()));
        if (fresh) local.push_back(node);
        nodes.of.back()[i] = at->second;
      }
    }
    return nodes;
  }

  // Two nodes of one pad are nearer than twice its radius and the longest edge.
  void find_near() {
    std::vector<Vec3> place(static_cast<std::size_t>(d->free_nodes) + 2);
    for (std::size_t node = 0; node < d->local.size(); ++node) {
      const std::size_t corners = body->mesh.nodes.size();
      const auto at = [&](NodeIndex i) { return body->mesh.nodes[i]; };
      place[static_cast<std::size_t>(d->local[node])] =
          node < corners ? at(static_cast<NodeIndex>(node))
                         : Vec3(0.5 * (at(d->edges[node - corners][0]) + at(d->edges[node - corners][1])));
    }
    double edge = 0;
    for (std::size_t f = 0; f < map.facets().size(); ++f) {
      const auto [a, b, c] = map.corners(static_cast<std::int32_t>(f));
      edge = std::max({edge, (b - a).norm(), (c - b).norm(), (a - c).norm()});
    }
    const double reach = 2 * (body->pad->radius + edge);
    near.resize(local.size());
    compliance.resize(local.size());
    for (std::size_t i = 0; i < local.size(); ++i) {
      for (std::size_t j = 0; j < local.size(); ++j)
        if ((place[static_cast<std::size_t>(local[i])] - place[static_cast<std::size_t>(local[j])]).norm() <=
            reach)
          near[i].push_back(static_cast<std::int32_t>(j));
      compliance[i].resize(9 * near[i].size());
    }
  }

  // Visits what is kept of eight columns of C, number by number.
  template <class Visit>
  void visit_columns(std::size_t first, Visit visit) {
    for (std::size_t k = first; k < std::min(first + lane_count, 3 * local.size()); ++k)
      for (std::size_t i = 0; i < near[k / 3].size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) visit(compliance[k / 3][9 * i + 3 * c + k % 3], k, i, c);
  }
  std::vector<double> packed_columns(std::size_t first) {
    std::vector<double> values;
    visit_columns(first, [&](double value, auto...) { values.push_back(value); });
    return values;
  }
  void take_columns(std::size_t first, std::span<const double> values) {
    std::size_t at = 0;
    visit_columns(first, [&](double& value, auto...) { value = values[at++]; });
  }

  // Eight columns of C, of the nodes' three components one after the other.
  void solve_columns(const Factorisation& solver, std::size_t first, std::vector<double>& lanes) {
    const std::size_t last = std::min(first + lane_count, 3 * local.size());
    std::ranges::fill(lanes, 0.0);
    for (std::size_t k = first; k < last; ++k)
      lanes[(3 * static_cast<std::size_t>(local[k / 3]) + k % 3) * lane_count + (k - first)] = 1;
    solver.solve_lanes(lanes.data());
    visit_columns(first, [&](double& value, std::size_t k, std::size_t i, std::size_t c) {
      const auto row = static_cast<std::size_t>(local[static_cast<std::size_t>(near[k / 3][i])]);
      value = lanes[(3 * row + c) * lane_count + (k - first)];
    });
  }

  bool take(std::span<const double> known) {
    std::size_t size = 0;
    for (const std::vector<double>& column : compliance) size += column.size();
    if (known.size() != size) return false;
    for (std::vector<double>& column : compliance) {
      std::ranges::copy(known.first(column.size()), column.begin());
      known = known.subspan(column.size());
    }
    return true;
  }

  Local at(const SurfacePlace& site, bool slopes) const {
    Local here;
    here.pad = pad->at(site, slopes);
    const Index n = here.size();
    here.compliance.resize(3 * n, 3 * n);
    for (Index j = 0; j < n; ++j) {
      const auto column = static_cast<std::size_t>(here.pad.nodes[static_cast<std::size_t>(j)]);
      std::size_t at = 0;
      for (Index i = 0; i < n; ++i) {
        while (near[column][at] != here.pad.nodes[static_cast<std::size_t>(i)]) ++at;
        for (Index c = 0; c < 3; ++c)
          for (Index e = 0; e < 3; ++e)
            here.compliance(c * n + i, e * n + j) =
                compliance[column][9 * at + static_cast<std::size_t>(3 * c + e)];
      }
    }
    here.system.compute(MatrixXd::Identity(3 * n, 3 * n) + here.springs_times(here.compliance));
    here.pull.setZero(3 * n, 3);
    for (Index c = 0; c < 3; ++c) here.pull.block(c * n, c, n, 1) = here.pad.pull;
    here.pull = here.system.solve(here.pull).eval();
    here.tangent = here.compliance * here.pull;
    return here;
  }

  static Mat3 stiffness(const Local& here) {
    Mat3 k = here.pad.total * Mat3::Identity();
    for (Index c = 0; c < 3; ++c)
      k.row(c) -= here.pad.pull.transpose() * here.tangent.middleRows(c * here.size(), here.size());
    return 0.5 * (k + k.transpose());
  }
};

Mat3 SiteRest::body_stiffness() const {
  return (stiffness.inverse() - Mat3::Identity() / springs).inverse();
}

RestSites::RestSites(std::shared_ptr<const Body> body, int threads, std::span<const double> compliance,
                     const std::function<void(double)>& progress, KeptPieces* kept) {
  if (!body->pad) throw InputError("pad", "missing, expected a body with a pad");
  impl_ = std::make_unique<Impl>(std::move(body));
  if (!compliance.empty() && impl_->take(compliance)) return;
  const std::size_t columns = 3 * impl_->local.size();
  std::vector<std::size_t> left;  // first of each piece
  for (std::size_t first = 0; first < columns; first += lane_count) {
    std::vector<double> values = kept ? impl_->packed_columns(first) : std::vector<double>();
    if (kept && kept->take(first, values))
      impl_->take_columns(first, values);
    else
      left.push_back(first);
  }
  const auto all = static_cast<double>((columns + lane_count - 1) / lane_count);
  std::size_t still = left.size();
  const auto show = [&] {
    if (progress) progress(1 - static_cast<double>(still) / all);
  };
  show();
  if (left.empty()) return;
  static_cast<void>(impl_->factor());  // throws here, not in a thread
#pragma omp parallel num_threads(threads)
  {
    const Factorisation factor = impl_->factor();
    std::vector<double> lanes(static_cast<std::size_t>(impl_->d->local_size()) * lane_count);
#pragma omp for schedule(dynamic)
    for (const std::size_t first : left) {
      impl_->solve_columns(factor, first, lanes);
#pragma omp critical
      {
        if (kept) kept->keep(first, impl_->packed_columns(first));
        --still;
        show();
      }
    }
  }
}
RestSites::~RestSites() = default;

const Body& RestSites::body() const {
  return *impl_->body;
}
const SurfaceMap& RestSites::map() const {
  return impl_->map;
}
const MovingPad& RestSites::pad() const {
  return *impl_->pad;
}
std::vector<double> RestSites::compliance() const {
  std::vector<double> list;
  for (const std::vector<double>& column : impl_->compliance)
    list.insert(list.end(), column.begin(), column.end());
  return list;
}

SiteRest RestSites::at(const SurfacePlace& site, bool slopes) const {
  const Local here = impl_->at(site, slopes);
  const PadAt& pad = here.pad;
  SiteRest rest{.stiffness = Impl::stiffness(here),
                .normal = pad.normal,
                .normal_by = pad.normal_by,
                .springs = pad.total,
                .clamped_share = pad.clamped_share};
  const Index n = here.size();
  for (std::size_t k = 0; k < 3 && slopes; ++k) {
    Mat3 by = pad.total_by[static_cast<Index>(k)] * Mat3::Identity();
    for (Index c = 0; c < 3; ++c) {
      const auto u = here.tangent.middleRows(c * n, n);
      by += u.transpose() * (pad.springs_by[k] * u).eval();
      const Vec3 pulled = u.transpose() * pad.pull_by[k];
      by.row(c) -= pulled.transpose();
      by.col(c) -= pulled;
    }
    rest.stiffness_by[k] = 0.5 * (by + by.transpose());
  }
  return rest;
}

struct SiteJets::Impl {
  const RestSites::Impl& sites;
  Factorisation factor;
  JetMaker maker;
  std::vector<double> rest, tangent, lanes;

  explicit Impl(const RestSites::Impl& of) : sites(of), factor(of.factor()), maker(of.d) {
    const auto size = static_cast<std::size_t>(of.d->local_size());
    rest.assign(size, 0.0), tangent.assign(3 * size, 0.0), lanes.assign(size * lane_count, 0.0);
  }

  std::size_t row(const Local& here, Index node, Index c) const {
    const auto surface = static_cast<std::size_t>(here.pad.nodes[static_cast<std::size_t>(node)]);
    return static_cast<std::size_t>(3 * sites.local[surface] + c) * lane_count;
  }

  void spread(const Local& here, const MatrixXd& at_pad) {
    std::ranges::fill(lanes, 0.0);
    for (Index i = 0; i < here.size(); ++i)
      for (Index c = 0; c < 3; ++c)
        for (Index lane = 0; lane < at_pad.cols(); ++lane)
          lanes[row(here, i, c) + static_cast<std::size_t>(lane)] = at_pad(c * here.size() + i, lane);
    factor.solve_lanes(lanes.data());
  }

  void set_tangent(const Local& here) {
    spread(here, here.pull);
    const std::size_t size = rest.size(), contact = static_cast<std::size_t>(3 * sites.d->free_nodes);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < contact; ++i) tangent[c * size + i] = lanes[i * lane_count + c];
      tangent[c * size + contact + c] = 1;
    }
  }

  void solve(const Local& here, double* b) {
    factor.solve_lanes(b);
    MatrixXd at_pad(3 * here.size(), lane_count);
    for (Index i = 0; i < here.size(); ++i)
      for (Index c = 0; c < 3; ++c)
        for (Index lane = 0; lane < lane_count; ++lane)
          at_pad(c * here.size() + i, lane) = b[row(here, i, c) + static_cast<std::size_t>(lane)];
    spread(here, here.system.solve(here.springs_times(at_pad)));
    for (std::size_t i = 0; i < lanes.size(); ++i) b[i] -= lanes[i];
  }
};

SiteJets::SiteJets(const RestSites& sites) : impl_(std::make_unique<Impl>(*sites.impl_)) {}
SiteJets::~SiteJets() = default;
SiteJets::SiteJets(SiteJets&&) noexcept = default;

RestJet SiteJets::at(const SurfacePlace& site) {
  const Local here = impl_->sites.at(site, false);
  impl_->set_tangent(here);
  const JetSolves solves{[&](double* b) { impl_->solve(here, b); }, {}};
  return {RestSites::Impl::stiffness(here),
          impl_->maker.at(impl_->rest, impl_->tangent, solves, most_jet_order)};
}

std::vector<double> SiteJets::tangent(const SurfacePlace& site) {
  impl_->set_tangent(impl_->sites.at(site, false));
  const std::size_t size = impl_->rest.size(), nodes = impl_->sites.body->mesh.nodes.size();
  std::vector<double> tangent(9 * nodes);
  for (std::size_t node = 0; node < nodes; ++node)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        tangent[9 * node + 3 * i + c] =
            impl_->tangent[c * size + 3 * static_cast<std::size_t>(impl_->sites.d->local[node]) + i];
  return tangent;
}

}  // namespace forefeel
