#pragma once
// The elements of a body as the kernels see them: groups of eight, each group of one material, so that its
// law and constants are those of all eight lanes. Local nodes and vectors: discretisation.hpp.
//   r += dW/du     blocks += d2W/du2     y_c += (d2W/du2)(u) d_c
// with W [J] the stored energy of all materials, of the pad and of the fine jet, r [N], blocks and d2W/du2 [N/m].

#include <cstddef>
#include <cstdint>
#include <vector>

#include "solver/body/body.hpp"
#include "solver/kernels/kernels.hpp"
#include "solver/system/pad_springs.hpp"
#include "solver/system/tip_energy.hpp"

namespace forefeel {

// Consecutive groups of one material.
struct MaterialGroups {
  std::int64_t first = 0, count = 0;
  LawConstants constants;
  const LawEntry* law = nullptr;
};

struct ElementGroups {
  int nodes_per_element = 4;
  std::vector<MaterialGroups> materials;
  // Padded with elements of no volume up to the end of each material's last group; shapes: ElementView.
  std::vector<std::int32_t> node, block;
  std::vector<double> gradient_of_node, volume;
  std::vector<std::int8_t> block_kind;
  PadSprings pad;
  TipEnergy fine;

  std::size_t count() const { return volume.size() / lane_count; }  // groups
  ElementView view(const MaterialGroups& of) const;

  // The loops of ElementKernels (kernels.hpp) over all materials, the pad's springs and the fine jet.
  FieldSummary gradient(const double* u, double* r) const;
  void hessian(const double* u, double* blocks) const;
  void gradient_lanes(const double* u, double* r, double* energy, double* min_jacobian) const;
  void product(std::int64_t stride, const double* u, const double* d, double* y) const;
  void product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const;
  // The loops of JetKernels; a pad's springs are linear and add nothing to the curvature.
  void curvature(std::int64_t stride, const double* u, const double* d, double* q,
                 const JetDirections& directions) const;
  void path(std::int64_t stride, const double* u, const double* tangent, const double* v, double* out,
            const JetDirections& directions) const;
};

// Groups without elements, one range for each material of the body.
ElementGroups empty_groups(const Body& body, const std::vector<MaterialPart>& parts);

}  // namespace forefeel
