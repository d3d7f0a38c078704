#pragma once
// What places still need once the states that are being solved are there:
//   left_s(q) = need_s(q) prod_p (1 - m_s(q, p)),    m_s(q, p) = (1 - |q - p|^2 inverse_s)_+
// over the states p under way, in their order, for each scale s. Kept from one call to the next: a state more costs
// one pass over the places, and so does leaving out a few of many.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

class NeedLeft {
 public:
  static constexpr std::size_t scales = 3;
  using Needs = std::array<double, scales>;

  // New places with their needs, nothing under way; inverses [1/m^2].
  void begin(std::span<const Vec3> at, std::span<const Needs> needs, const Needs& inverses);
  // Accounts for these and no others.
  void set(std::span<const Vec3> under_way);

  std::size_t places() const { return at_.size(); }
  Vec3 at(std::size_t i) const { return at_[i]; }
  Needs left(std::size_t i) const {
    Needs needs{};
    for (std::size_t s = 0; s < scales; ++s)
      if (const std::uint32_t j = rows_[s].of[i]; j != none) needs[s] = rows_[s].left[j];
    return needs;
  }
  std::span<const Vec3> under_way() const { return counted_; }

 private:
  void multiply(const Vec3& p);
  void anew(std::span<const Vec3> under_way);
  bool leave_out(std::span<const Vec3> under_way);

  static constexpr std::uint32_t none = 0xffffffffu;
  struct Row {  // a scale: the places that need anything at it
    double inverse = 0;
    std::vector<std::uint32_t> place, of;  // #row -> place, #places -> row or none
    std::vector<double> xyz, need, left;   // a coordinate a row; #row
  };
  std::vector<Vec3> at_;
  std::array<Row, scales> rows_;
  std::vector<Vec3> counted_;  // what is accounted for
  std::array<std::vector<double>, scales>
      all_left_;  // of the longest list lately, from which some may be left out
  std::vector<Vec3> all_;
};

}  // namespace forefeel
