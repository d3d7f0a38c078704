#pragma once
// The adaptive lattice: an octree whose leaves are as wide as the spacing asked for there, 2:1 balanced over faces,
// edges and corners. States belong at the corners of the leaves; leaves of one width s have their corners at {k s}^3,
// so an unrefined lattice is {k h}^3 and rest is always a corner.
//   h(q) = the largest spacing among the leaves that touch q's leaf (itself included) [m]

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

struct LatticeLeaf {
  Box box;             // [m]
  double spacing = 0;  // side [m]
  int level = 0;       // 0: as wide as the coarsest spacing
};

class AdaptiveLattice {
 public:
  // Covers `box` by leaves of side `coarsest` [m], enlarged to whole leaves.
  AdaptiveLattice(const Box& box, double coarsest);

  // Splits leaves until each is at most target(leaf) wide, or max_level deep, then whatever the balance needs.
  // Returns how many leaves were split.
  std::size_t refine(const std::function<double(const LatticeLeaf&)>& target, int max_level = 6);

  double spacing_at(const Vec3& q) const;  // h(q); outside the leaves that of the nearest place in them
  // h(q) where it is the same for all q of the box because one leaf holds them all.
  std::optional<double> spacing_over(const Box& box) const;
  LatticeLeaf leaf_at(const Vec3& q) const;
  std::vector<LatticeLeaf> leaves() const;
  // The corners of all leaves inside the box as given, with the smallest spacing that meets there; outward from rest.
  struct Point {
    Vec3 at;
    double spacing;
  };
  std::vector<Point> points() const;
  double coarsest() const { return coarsest_; }

 private:
  struct Node {
    std::int32_t children = -1;
    std::int32_t level = 0;
    std::int32_t widest = 0;            // of a leaf: the least level among the leaves that touch it
    std::array<std::int32_t, 3> low{};  // in units of its own side
  };
  using Cell = std::array<std::int32_t, 3>;

  std::int32_t leaf_index(const Cell& fine) const;  // by cell of the finest level, clamped into the leaves
  Cell fine_cell(const Vec3& q) const;
  Box box_of(const Node& node) const;
  double side_of(const Node& node) const;
  void find_widest();
  void split(std::int32_t index);
  void split_balanced(std::int32_t index, std::size_t& count);
  template <class Visit>
  void for_each_touching(const Node& node, Visit&& visit) const;

  Box asked_;
  double coarsest_;
  Cell low_{}, roots_{};
  std::vector<Node> nodes_;
};

// The lattice that states with target spacings (State::spacing) lie on: as wide as the widest of them, and no wider in
// a leaf than the spacing of any state inside it. None where no state says, or all say the same.
std::optional<AdaptiveLattice> lattice_of(std::span<const State> states, const Box& box);

}  // namespace forefeel
