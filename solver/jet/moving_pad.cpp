#include "solver/jet/moving_pad.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solver/body/pad_quadrature.hpp"

namespace forefeel {

// The integrals over one facet, without g: of N_i N_j, i <= j, and their derivatives by s.
struct MovingPad::Part {
  std::int32_t facet = -1;
  std::array<double, 21> springs{};
  std::array<std::array<double, 21>, 3> by{};
  double weight = 0;  // int 3 k_p / (pi r^2) F^2 dA
  Vec3 weight_by = Vec3::Zero();
};

namespace {

using pad_quadrature::cross;
using pad_quadrature::Vec2;

constexpr std::size_t pair_of(std::size_t i, std::size_t j) {  // i <= j
  return j * (j + 1) / 2 + i;
}

// Visits quadrature points of the triangle; its vertices are positively oriented.
template <class Visit>
void over_whole(const std::array<Vec2, 3>& p, const Visit& visit) {
  const pad_quadrature::GaussRule& rule = pad_quadrature::gauss_rule();
  const Vec2 a = p[1] - p[0], b = p[2] - p[0];
  const double twice = cross(a, b);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t k = 0; k < 8; ++k) {
      const double s = rule.at[i], t = rule.at[k];
      visit(Vec2(p[0] + s * ((1 - t) * a + t * b)), rule.weight[i] * rule.weight[k] * s * twice);
    }
}

}  // namespace

MovingPad::MovingPad(const SurfaceMap& map, double radius, double stiffness, FacetNodes nodes)
    : map_(map), radius_(radius), stiffness_(stiffness), nodes_(std::move(nodes)) {}

// The facets of S: reached from the site across edges nearer than r.
std::vector<std::int32_t> MovingPad::component(const SurfacePlace& site) const {
  std::vector<std::int32_t> found{site.facet};
  for (std::size_t next = 0; next < found.size(); ++next) {
    const SurfaceMap::Facet& facet = map_.facets()[static_cast<std::size_t>(found[next])];
    const std::array<Vec3, 3> corner = map_.corners(found[next]);
    for (std::size_t e = 0; e < 3; ++e) {
      const std::int32_t beside = facet.beside[e];
      if (beside < 0 || std::ranges::find(found, beside) != found.end()) continue;
      const Vec3 &a = corner[e], way = corner[(e + 1) % 3] - a;
      const double t = std::clamp(way.dot(site.at - a) / way.squaredNorm(), 0.0, 1.0);
      if ((a + t * way - site.at).norm() < radius_) found.push_back(beside);
    }
  }
  std::ranges::sort(found);
  return found;
}

MovingPad::Part MovingPad::integrate(std::int32_t number, const Vec3& site, bool slopes) const {
  Part part{.facet = number};
  const auto [a, b, c] = map_.corners(number);
  const Vec3& normal = map_.facets()[static_cast<std::size_t>(number)].normal;
  const double height = normal.dot(site - a), r2 = radius_ * radius_;
  if (height * height >= r2) return part;
  const Vec3 foot = site - height * normal, e1 = (b - a).normalized(), e2 = normal.cross(e1);
  const auto flat = [&](const Vec3& p) { return Vec2(e1.dot(p - foot), e2.dot(p - foot)); };
  const std::array<Vec2, 3> corner{flat(a), flat(b), flat(c)};
  const double twice = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const double peak = 3 * stiffness_ / (std::numbers::pi * r2);
  const auto count = static_cast<std::size_t>(nodes_.per_facet);
  const auto visit = [&](const Vec2& y, double weight) {
    const Vec3 l(cross(corner[1] - y, corner[2] - y) / twice, cross(corner[2] - y, corner[0] - y) / twice,
                 cross(corner[0] - y, corner[1] - y) / twice);
    const double fall = 1 - (height * height + y.squaredNorm()) / r2, density = weight * peak * fall * fall;
    const std::array<double, 6> n = pad_quadrature::shapes(l, nodes_.per_facet);
    const Vec3 slope = weight * peak * fall * 4 / r2 * (e1 * y.x() + e2 * y.y() - height * normal);
    part.weight += density;
    part.weight_by += slope;
    for (std::size_t j = 0, at = 0; j < count; ++j)
      for (std::size_t i = 0; i <= j; ++i, ++at) {
        const double product = n[i] * n[j];
        part.springs[at] += density * product;
        if (!slopes) continue;
        for (std::size_t k = 0; k < 3; ++k) part.by[k][at] += slope[static_cast<int>(k)] * product;
      }
  };
  const double disc = std::sqrt(r2 - height * height);
  if (std::ranges::all_of(corner, [&](const Vec2& p) { return p.squaredNorm() <= disc * disc; }))
    over_whole(corner, visit);
  else
    for (std::size_t e = 0; e < 3; ++e)
      pad_quadrature::over_edge(corner[e], corner[(e + 1) % 3], disc, visit);
  return part;
}

void MovingPad::gather(const std::vector<Part>& parts, bool slopes, PadAt& pad) const {
  const auto count = static_cast<std::size_t>(nodes_.per_facet);
  for (const Part& part : parts)
    for (std::size_t i = 0; i < count; ++i)
      if (const std::int32_t node = nodes_.of[static_cast<std::size_t>(part.facet)][i]; node >= 0)
        pad.nodes.push_back(node);
  std::ranges::sort(pad.nodes);
  pad.nodes.erase(std::unique(pad.nodes.begin(), pad.nodes.end()), pad.nodes.end());
  const auto size = static_cast<Eigen::Index>(pad.nodes.size());
  pad.springs.setZero(size, size);
  pad.pull.setZero(size);
  for (std::size_t k = 0; k < 3 && slopes; ++k)
    pad.springs_by[k].setZero(size, size), pad.pull_by[k].setZero(size);
  double clamped = 0;
  for (const Part& part : parts) {
    const Vec3& normal = map_.facets()[static_cast<std::size_t>(part.facet)].normal;
    const double cosine = normal.dot(pad.normal), g = pad_quadrature::facing(cosine);
    const Vec3 g_by = pad_quadrature::facing_slope(cosine) * (pad.normal_by.transpose() * normal);
    std::array<Eigen::Index, 6> row{};
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t node = nodes_.of[static_cast<std::size_t>(part.facet)][i];
      row[i] = node < 0 ? -1 : std::ranges::lower_bound(pad.nodes, node) - pad.nodes.begin();
    }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j) {
        const std::size_t at = pair_of(std::min(i, j), std::max(i, j));
        const double value = g * part.springs[at];
        pad.total += value;
        if (row[i] < 0) clamped += value;
        if (row[i] >= 0) pad.pull[row[i]] += value;
        if (row[i] >= 0 && row[j] >= 0) pad.springs(row[i], row[j]) += value;
        for (std::size_t k = 0; k < 3 && slopes; ++k) {
          const double by = g * part.by[k][at] + g_by[static_cast<int>(k)] * part.springs[at];
          pad.total_by[static_cast<int>(k)] += by;
          if (row[i] >= 0) pad.pull_by[k][row[i]] += by;
          if (row[i] >= 0 && row[j] >= 0) pad.springs_by[k](row[i], row[j]) += by;
        }
      }
  }
  pad.clamped_share = pad.total > 0 ? clamped / pad.total : 1;
}

PadAt MovingPad::at(const SurfacePlace& site, bool slopes) const {
  PadAt pad;
  std::vector<Part> parts;
  Vec3 mean = Vec3::Zero();
  Mat3 mean_by = Mat3::Zero();
  for (const std::int32_t facet : component(site)) {
    parts.push_back(integrate(facet, site.at, slopes));
    const Vec3& normal = map_.facets()[static_cast<std::size_t>(facet)].normal;
    mean += parts.back().weight * normal;
    mean_by += normal * parts.back().weight_by.transpose();
  }
  if (const double size = mean.norm(); size > 1e-9 * stiffness_) {
    pad.normal = mean / size;
    pad.normal_by = (Mat3::Identity() - pad.normal * pad.normal.transpose()) * mean_by / size;
  }
  gather(parts, slopes, pad);
  return pad;
}

Vec3 MovingPad::normal(const SurfacePlace& site) const {
  Vec3 mean = Vec3::Zero();
  for (const std::int32_t facet : component(site))
    mean += integrate(facet, site.at, false).weight * map_.facets()[static_cast<std::size_t>(facet)].normal;
  return mean.norm() > 1e-9 * stiffness_ ? Vec3(mean.normalized()) : Vec3(Vec3::Zero());
}

}  // namespace forefeel
