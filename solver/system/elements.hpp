#pragma once
// The elements of a body as the kernels see them: groups of eight, each group of one material, so that its
// law and constants are those of all eight lanes. Local nodes and vectors: discretisation.hpp.
//   r += dW/du     blocks += d2W/du2     y_c += (d2W/du2)(u) d_c
// with W [J] the stored energy of all materials, of the pad and of the fine jet, r [N], blocks and d2W/du2 [N/m].

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "solver/body/body.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/kernels/kernels.hpp"

namespace forefeel {

// The fine jet dE(x) of a body (solver/body/fine_jet.hpp) as an energy of the contact's local node, whose displacement
// is x: force, stiffness and energy of every solve contain it, and no free node feels it.

struct TipEnergy {
  std::shared_ptr<const FineJet> jet;  // null: none
  std::int64_t node = 0, block = 0;    // the contact's local node and its own block of the pattern

  // As the loops of ElementGroups, for local vectors and eight side by side; add_gradient returns dE.
  double add_gradient(const double* u, double* r) const;
  void add_hessian(const double* u, double* blocks) const;
  void add_gradient_lanes(const double* u, double* r, double* energy) const;
  void add_product(std::int64_t stride, const double* u, const double* d, double* y) const;
  void add_product_lanes(std::int64_t stride, const double* u, const double* d, double* y) const;
};

// The springs of a compliant pad (solver/body/pad.hpp) over local nodes, the tip included:
//   E_pad = 1/2 sum_ij M_ij w_i . w_j = 1/2 u^T M u,   w_i = u_i - x
// M [N/m] couples nodes, not components: each entry stands for M_ij I. The row of the tip is minus the sum of the
// others, so a shift of body and tip together costs nothing. Clamped nodes have u = 0 and no row.

struct PadSprings {
  // Entry a <= b of M, local nodes, and its block of Discretisation::pattern.
  struct Pair {
    std::int32_t a = 0, b = 0;
    std::int64_t block = 0;
    double stiffness = 0;
  };
  std::vector<Pair> pairs;

  double energy(const double* u) const;                      // [J]
  void apply(const double* u, double* y) const;              // y += M u, [N]
  void apply_lanes(const double* u, double* y) const;        // of eight fields side by side
  void energy_lanes(const double* u, double* energy) const;  // energy[8] +=
  void add_to(double* blocks) const;                         // blocks += M
};

// Consecutive groups of one material. Large bodies have several of each material, for threads to share (share_out.hpp).
struct MaterialGroups {
  std::int64_t first = 0, count = 0;
  LawConstants constants;
  const LawEntry* law = nullptr;
};

struct ElementGroups {
  int nodes_per_element = 4;
  std::vector<MaterialGroups> materials;
  // Padded with elements of no volume up to the end of each material's last group; shapes: ElementView.
  std::vector<std::int32_t> node, row, block;
  // What several of `materials` add to: the rows and blocks of their tails, which are added up in this order.
  std::vector<std::int32_t> met_rows, met_blocks;
  std::vector<double> gradient_of_node, volume;
  std::vector<std::int8_t> block_kind;
  PadSprings pad;
  TipEnergy fine;

  std::size_t count() const { return volume.size() / lane_count; }  // groups
  ElementView view(const MaterialGroups& of) const;
  bool is_large() const;
  // Cuts a large body's groups into ranges; all else must be set.
  void share();

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

 private:
  // loop(kernels, i, view) for each of `materials`, with the tails of what they add to
  template <class Loop>
  void each_range(double* tail, std::int64_t stride, const Loop& loop) const;
};

// Groups without elements, one range for each material of the body.
ElementGroups empty_groups(const Body& body, const std::vector<MaterialPart>& parts);

}  // namespace forefeel
