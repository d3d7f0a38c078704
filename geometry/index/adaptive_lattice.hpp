#pragma once
// The adaptive lattice: an octree whose leaves are as wide as the wanted spacing. Leaves that touch (over faces,
// edges or corners) differ by at most one level. States lie at the corners of the leaves. Leaves of width s have
// their corners at {k s}^3, so a lattice without refinement is {k h}^3, and rest is always a corner.
//   h(q) = the largest spacing among the leaves that touch q's leaf, itself included [m]

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geometry/common/signed_vector.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {

struct LatticeLeaf {
  Box box;             // [m]
  double spacing = 0;  // side [m]
  int level = 0;       // 0: as wide as the coarsest spacing
};

class AdaptiveLattice {
 public:
  // Covers `box` with whole leaves of side `coarsest` [m]. InputError if that is not > 0, or beyond 1e8
  // leaves.
  AdaptiveLattice(const Box& box, double coarsest);

  // Splits leaves until each is at most target(leaf) [m] wide or max_level deep. Splits other leaves as needed to
  // keep neighbours within one level. Returns the number of splits.
  std::size_t refine(const std::function<double(const LatticeLeaf&)>& target, int max_level = 6);

  double spacing_at(const Vec3& q) const;  // h(q); outside the leaves, that of the nearest place inside
  // h(q) if one leaf holds the whole box, so that h is constant in it.
  std::optional<double> spacing_over(const Box& box) const;
  LatticeLeaf leaf_at(const Vec3& q) const;
  std::vector<LatticeLeaf> leaves() const;
  // The corners of all leaves inside the given box, outward from rest, with the smallest spacing of their
  // leaves.
  struct Point {
    Vec3 at;         // [m]
    double spacing;  // [m]
  };
  std::vector<Point> points() const;
  double coarsest() const { return coarsest_; }

 private:
  struct Node {
    std::int32_t children = -1;
    std::int32_t level = 0;
    std::int32_t widest = 0;            // of a leaf: lowest level among the leaves that touch it
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
  SignedVector<Node> nodes_;
};

// The lattice on which states with target spacings (State::spacing) lie. Its coarsest spacing is the largest
// target spacing, and no leaf is wider than the target spacing of a state inside it. nullopt if no state has a
// target spacing, or if all have the same.
std::optional<AdaptiveLattice> lattice_of(std::span<const State> states, const Box& box);

}  // namespace forefeel
