#include "solver/system/elements.hpp"

#include <algorithm>
#include <array>

#include "solver/body/law.hpp"
#include "solver/body/law_table.hpp"

namespace forefeel {

ElementView ElementGroups::view(const MaterialGroups& of) const {
  const auto first = static_cast<std::size_t>(of.first), lanes = std::size_t{lane_count},
             nodes = static_cast<std::size_t>(nodes_per_element), pairs = nodes * (nodes + 1) / 2;
  ElementView v;
  v.groups = of.count;
  v.nodes_per_element = nodes_per_element;
  v.node = node.data() + first * nodes * lanes;
  v.gradient = gradient_of_node.data() + first * 12 * lanes;
  v.volume = volume.data() + first * lanes;
  v.block = block.data() + first * pairs * lanes;
  v.block_kind = block_kind.data() + first * pairs * lanes;
  v.constants = of.constants;
  return v;
}

FieldSummary ElementGroups::gradient(const double* u, double* r) const {
  FieldSummary all = materials.front().law->kernels.gradient(view(materials.front()), u, r);
  for (std::size_t m = 1; m < materials.size(); ++m) {
    const FieldSummary its = materials[m].law->kernels.gradient(view(materials[m]), u, r);
    all.energy += its.energy;
    all.min_jacobian = std::min(all.min_jacobian, its.min_jacobian);
  }
  all.energy += pad.energy(u);
  pad.apply(u, r);
  all.energy += fine.add_gradient(u, r);
  return all;
}

void ElementGroups::hessian(const double* u, double* blocks) const {
  for (const MaterialGroups& of : materials) of.law->kernels.hessian(view(of), u, blocks);
  pad.add_to(blocks);
  fine.add_hessian(u, blocks);
}

void ElementGroups::gradient_lanes(const double* u, double* r, double* energy, double* min_jacobian) const {
  materials.front().law->kernels.gradient_lanes(view(materials.front()), u, r, energy, min_jacobian);
  std::array<double, lane_count> its_energy{}, its_jacobian{};
  for (std::size_t m = 1; m < materials.size(); ++m) {
    materials[m].law->kernels.gradient_lanes(view(materials[m]), u, r, its_energy.data(),
                                             its_jacobian.data());
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
      energy[lane] += its_energy[lane];
      min_jacobian[lane] = std::min(min_jacobian[lane], its_jacobian[lane]);
    }
  }
  pad.energy_lanes(u, energy);
  pad.apply_lanes(u, r);
  fine.add_gradient_lanes(u, r, energy);
}

void ElementGroups::product(std::int64_t stride, const double* u, const double* d, double* y) const {
  for (const MaterialGroups& of : materials) of.law->kernels.product(view(of), stride, u, d, y);
  for (std::int64_t c = 0; c < 3; ++c) pad.apply(d + c * stride, y + c * stride);
  fine.add_product(stride, u, d, y);
}

void ElementGroups::product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const {
  for (const MaterialGroups& of : materials) of.law->kernels.product_lanes(view(of), stride, u, d, y);
  for (std::int64_t c = 0; c < 3; ++c) pad.apply_lanes(d + c * stride, y + c * stride);
  fine.add_product_lanes(stride, u, d, y);
}

namespace {

JetDirections of_groups(JetDirections directions, const MaterialGroups& of) {
  if (directions.hardness) directions.hardness += of.first;
  return directions;
}

}  // namespace

void ElementGroups::curvature(std::int64_t stride, const double* u, const double* d, double* q,
                              const JetDirections& directions) const {
  for (const MaterialGroups& of : materials)
    of.law->jets.curvature(view(of), stride, u, d, q, of_groups(directions, of));
}

void ElementGroups::path(std::int64_t stride, const double* u, const double* tangent, const double* v,
                         double* out, const JetDirections& directions) const {
  for (const MaterialGroups& of : materials)
    of.law->jets.path(view(of), stride, u, tangent, v, out, of_groups(directions, of));
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
