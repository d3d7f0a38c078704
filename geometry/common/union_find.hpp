#pragma once
// Disjoint sets over 0 … n - 1. find() names the set of i; join() unites two sets. Path halving: nearly O(1)
// each.

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace forefeel {

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace forefeel
