#pragma once
// A body as the kernels see it. Local nodes: 0 .. n-1 free, in elimination order; n the contact (all contact
// nodes, or the tip behind a pad, which move by x); n+1 the clamp. Local vectors are (n+2) x 3 [m] or [N]. The contact
// is one local node: its row of dW/du is minus the force on the HIP, and eliminating the free nodes from d2W/du2 leaves
// the condensed stiffness K.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "solver/body/body.hpp"
#include "solver/system/elements.hpp"

namespace forefeel {

// Upper triangle of d2W/du2 in 3 x 3 blocks, over the free nodes and the contact: row i holds columns j >= i,
// ascending, its diagonal first. Block number size() of a value array is a dummy for the entries of the
// clamp.
struct BlockPattern {
  std::vector<std::int64_t> row_start;  // n + 2
  std::vector<std::uint32_t> column;
  std::int64_t size() const { return static_cast<std::int64_t>(column.size()); }
  std::int64_t block(std::uint32_t i, std::uint32_t j) const;  // of row i <= column j, which it holds
  std::span<const std::uint32_t> row(std::size_t i) const {
    return {column.begin() + row_start[i], column.begin() + row_start[i + 1]};
  }
};

struct FactorLayout;  // factorisation.cpp

struct Discretisation {
  std::int64_t free_nodes = 0;                  // n
  std::int64_t nodes = 0;                       // of the elements: mesh nodes, then mid-edge nodes
  std::vector<std::array<NodeIndex, 2>> edges;  // of the mid-edge nodes (quadratic elements)
  std::vector<std::int32_t> local;              // node -> local node
  BlockPattern pattern;
  double force_floor = 0;  // 1e-12 E L^2 [N], E of the stiffest material
  double round_off = 0;    // smaller residuals are rounding error [N]
  ElementGroups elements;
  std::shared_ptr<const FactorLayout> layout = {};  // of factors of one precision; the others make their own

  std::int64_t local_size() const { return 3 * (free_nodes + 2); }
  // #V x 3 by node (mesh nodes, then mid-edge nodes) <-> local vector. A node that no element uses stays at
  // rest.
  void to_local(const std::vector<double>& by_node, double* u) const;
  std::vector<double> to_nodes(const double* u) const;
};

// Clamp and contact may be empty (then all nodes are free).
Discretisation discretise(const Body& body);

// The springs of body.pad over the local nodes of d, which may be that of the body without a contact; none without a
// pad. Pairs come in order; their blocks are not set.
PadSprings pad_springs(const Body& body, const Discretisation& d);

}  // namespace forefeel
