#include "solver/system/elements.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "solver/body/law.hpp"
#include "solver/kernels/kernels.hpp"
#include "solver/system/share_out.hpp"

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

double PadSprings::energy(const double* u) const {
  double twice = 0;
  for (const Pair& p : pairs) {
    const double *a = u + 3 * p.a, *b = u + 3 * p.b;
    const double product = p.stiffness * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    twice += p.a == p.b ? product : 2 * product;
  }
  return 0.5 * twice;
}

void PadSprings::apply(const double* u, double* y) const {
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < 3; ++i) {
      *(y + 3 * p.a + i) += p.stiffness * *(u + 3 * p.b + i);
      if (p.a != p.b) *(y + 3 * p.b + i) += p.stiffness * *(u + 3 * p.a + i);
    }
}

void PadSprings::apply_lanes(const double* u, double* y) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs)
    for (std::int32_t i = 0; i < row; ++i) {
      *(y + row * p.a + i) += p.stiffness * *(u + row * p.b + i);
      if (p.a != p.b) *(y + row * p.b + i) += p.stiffness * *(u + row * p.a + i);
    }
}

void PadSprings::energy_lanes(const double* u, double* energy) const {
  constexpr std::int32_t row = 3 * lane_count;
  for (const Pair& p : pairs) {
    const double scale = p.a == p.b ? 0.5 * p.stiffness : p.stiffness;
    for (std::int32_t i = 0; i < row; ++i)
      *(energy + i % lane_count) += scale * *(u + row * p.a + i) * *(u + row * p.b + i);
  }
}

void PadSprings::add_to(double* blocks) const {
  for (const Pair& p : pairs)
    for (std::int64_t i = 0; i < 3; ++i) *(blocks + 9 * p.block + 4 * i) += p.stiffness;
}

ElementView ElementGroups::view(const MaterialGroups& of) const {
  const auto first = static_cast<std::size_t>(of.first), lanes = std::size_t{lane_count},
             nodes = static_cast<std::size_t>(nodes_per_element), pairs = nodes * (nodes + 1) / 2;
  ElementView v;
  v.groups = of.count;
  v.nodes_per_element = nodes_per_element;
  v.node = node.data() + first * nodes * lanes;
  v.row = row.data() + first * nodes * lanes;
  v.gradient = gradient_of_node.data() + first * 12 * lanes;
  v.volume = volume.data() + first * lanes;
  v.block = block.data() + first * pairs * lanes;
  v.block_kind = block_kind.data() + first * pairs * lanes;
  v.constants = of.constants;
  return v;
}

namespace {

constexpr std::int64_t worth_sharing = 500,
                       most_ranges = 16;  // groups; ranges, and one more for each material

// Moves the places that several ranges use to the tail: -1 - t is place met[t].
void move_to_tail(const std::vector<MaterialGroups>& ranges, std::size_t per_group,
                  std::vector<std::int32_t>& places, std::vector<std::int32_t>& met) {
  constexpr std::int32_t nobody = -1, several = -2;
  std::vector<std::int32_t> owner(1 + static_cast<std::size_t>(*std::ranges::max_element(places)), nobody);
  const auto each = [&](std::size_t range, const auto& use) {
    const auto first = places.begin() + ranges[range].first * static_cast<std::int64_t>(per_group);
    std::for_each(first, first + ranges[range].count * static_cast<std::int64_t>(per_group), use);
  };
  for (std::size_t range = 0; range < ranges.size(); ++range)
    each(range, [&](std::int32_t place) {
      std::int32_t& of = owner[static_cast<std::size_t>(place)];
      of =
          of == nobody || of == static_cast<std::int32_t>(range) ? static_cast<std::int32_t>(range) : several;
    });
  for (std::size_t range = 0; range < ranges.size(); ++range) {
    std::map<std::int32_t, std::int32_t> tail;
    each(range, [&](std::int32_t& place) {
      if (owner[static_cast<std::size_t>(place)] != several) return;
      const auto [known, is_new] = tail.emplace(place, -1 - static_cast<std::int32_t>(met.size()));
      if (is_new) met.push_back(place);
      place = known->second;
    });
  }
}

// v[met[t]] += tail[t], `size` numbers each
void add_tail(const std::vector<std::int32_t>& met, std::int64_t size, const double* tail, double* v) {
  for (const std::int32_t place : met)
    for (double* to = v + size * place; to < v + size * (place + std::int64_t{1}); ++to, ++tail) *to += *tail;
}

double* cleared(std::int64_t size) {
  static thread_local std::vector<double> space;
  space.assign(static_cast<std::size_t>(size), 0.0);
  return space.data();
}

}  // namespace

bool ElementGroups::is_large() const {
  return materials.back().first + materials.back().count >= worth_sharing;
}

void ElementGroups::share() {
  row = node;
  if (!is_large()) return;
  const std::int64_t each = (static_cast<std::int64_t>(count()) + most_ranges - 1) / most_ranges;
  std::vector<MaterialGroups> ranges;
  for (const MaterialGroups& of : materials)
    for (std::int64_t first = 0; first < of.count; first += each) {
      ranges.push_back(of);
      ranges.back().first = of.first + first;
      ranges.back().count = std::min(each, of.count - first);
    }
  materials = std::move(ranges);
  const auto nodes = static_cast<std::size_t>(nodes_per_element);
  move_to_tail(materials, nodes * lane_count, row, met_rows);
  move_to_tail(materials, nodes * (nodes + 1) / 2 * lane_count, block, met_blocks);
}

template <class Loop>
void ElementGroups::each_range(double* tail, std::int64_t stride, const Loop& loop) const {
  share_out(materials.size(), [&](std::size_t i) {
    ElementView its = view(materials[i]);
    its.tail = tail;
    its.tail_stride = stride;
    loop(materials[i].law->kernels, i, its);
  });
}

FieldSummary ElementGroups::gradient(const double* u, double* r) const {
  double* tail = cleared(3 * std::ssize(met_rows));
  std::vector<FieldSummary> of(materials.size());
  each_range(tail, 0, [&](const ElementKernels& kernels, std::size_t i, const ElementView& its) {
    of[i] = kernels.gradient(its, u, r);
  });
  add_tail(met_rows, 3, tail, r);
  FieldSummary all = of.front();
  for (std::size_t i = 1; i < of.size(); ++i) {
    all.energy += of[i].energy;
    all.min_jacobian = std::min(all.min_jacobian, of[i].min_jacobian);
  }
  all.energy += pad.energy(u);
  pad.apply(u, r);
  all.energy += fine.add_gradient(u, r);
  return all;
}

void ElementGroups::hessian(const double* u, double* blocks) const {
  double* tail = cleared(9 * std::ssize(met_blocks));
  each_range(tail, 0, [&](const ElementKernels& kernels, std::size_t, const ElementView& its) {
    kernels.hessian(its, u, blocks);
  });
  add_tail(met_blocks, 9, tail, blocks);
  pad.add_to(blocks);
  fine.add_hessian(u, blocks);
}

void ElementGroups::gradient_lanes(const double* u, double* r, double* energy, double* min_jacobian) const {
  double* tail = cleared(3 * lane_count * std::ssize(met_rows));
  struct Lanes {
    std::array<double, lane_count> energy, min_jacobian;
  };
  std::vector<Lanes> of(materials.size());
  each_range(tail, 0, [&](const ElementKernels& kernels, std::size_t i, const ElementView& its) {
    kernels.gradient_lanes(its, u, r, of[i].energy.data(), of[i].min_jacobian.data());
  });
  add_tail(met_rows, 3 * lane_count, tail, r);
  for (std::size_t lane = 0; lane < lane_count; ++lane) {
    energy[lane] = of.front().energy[lane];
    min_jacobian[lane] = of.front().min_jacobian[lane];
    for (std::size_t i = 1; i < of.size(); ++i) {
      energy[lane] += of[i].energy[lane];
      min_jacobian[lane] = std::min(min_jacobian[lane], of[i].min_jacobian[lane]);
    }
  }
  pad.energy_lanes(u, energy);
  pad.apply_lanes(u, r);
  fine.add_gradient_lanes(u, r, energy);
}

void ElementGroups::product(std::int64_t stride, const double* u, const double* d, double* y) const {
  const std::int64_t size = 3 * std::ssize(met_rows);
  double* tail = cleared(3 * size);
  each_range(tail, size, [&](const ElementKernels& kernels, std::size_t, const ElementView& its) {
    kernels.product(its, stride, u, d, y);
  });
  for (std::int64_t c = 0; c < 3; ++c) {
    add_tail(met_rows, 3, tail + c * size, y + c * stride);
    pad.apply(d + c * stride, y + c * stride);
  }
  fine.add_product(stride, u, d, y);
}

void ElementGroups::product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const {
  const std::int64_t size = 3 * lane_count * std::ssize(met_rows);
  double* tail = cleared(3 * size);
  each_range(tail, size, [&](const ElementKernels& kernels, std::size_t, const ElementView& its) {
    kernels.product_lanes(its, stride, u, d, y);
  });
  for (std::int64_t c = 0; c < 3; ++c) {
    add_tail(met_rows, 3 * lane_count, tail + c * size, y + c * stride);
    pad.apply_lanes(d + c * stride, y + c * stride);
  }
  fine.add_product_lanes(stride, u, d, y);
}

namespace {

// The fields of JetKernels.
std::vector<double> jet_fields(std::int64_t stride, const double* u, const double* d) {
  const std::int64_t nodes = stride / 3;
  std::vector<double> fields(static_cast<std::size_t>(jet_row * nodes));
  for (std::int64_t node = 0; node < nodes; ++node) {
    double* const row = fields.data() + jet_row * node;
    std::copy_n(u + 3 * node, 3, row);
    for (std::int64_t c = 0; c < 3; ++c) std::copy_n(d + c * stride + 3 * node, 3, row + 3 * (c + 1));
  }
  return fields;
}

JetDirections of_groups(JetDirections directions, const MaterialGroups& of) {
  if (directions.hardness) directions.hardness += of.first;
  return directions;
}

}  // namespace

void ElementGroups::curvature(std::int64_t stride, const double* u, const double* d, double* q,
                              const JetDirections& directions) const {
  const std::vector<double> fields = jet_fields(stride, u, d);
  for (const MaterialGroups& of : materials)
    of.law->jets.curvature(view(of), fields.data(), q, of_groups(directions, of));
}

void ElementGroups::path(std::int64_t stride, const double* u, const double* tangent, const double* v,
                         double* out, const JetDirections& directions) const {
  const std::vector<double> fields = jet_fields(stride, u, tangent);
  for (const MaterialGroups& of : materials)
    of.law->jets.path(view(of), fields.data(), v, out, of_groups(directions, of));
}

ElementGroups empty_groups(const Body& body, const std::vector<MaterialPart>& parts) {
  ElementGroups groups;
  groups.nodes_per_element = body.element == Element::quadratic ? 10 : 4;
  std::int64_t first = 0;
  for (const MaterialPart& part : parts) {
    const auto count = static_cast<std::int64_t>((part.tets.size() + lane_count - 1) / lane_count);
    groups.materials.push_back({first, count, law_constants(part.material), &law_entry(part.material.law)});
    first += count;
  }
  return groups;
}

}  // namespace forefeel
