#pragma once
// The need that remains at each place once the states being solved ("under way") are known, for each scale s:
//   left_s(q) = need_s(q) prod_p (1 - m_s(q, p)),    m_s(q, p) = (1 - |q - p|^2 inverse_s)_+
// where p runs over the states under way, in their order. The products are kept between calls, so adding a state, or
// removing a few of many, takes one pass over the places.

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
  // Sets the complete list of states under way [m].
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
  struct Row {  // of one scale: the places with a need there
    double inverse = 0;
    std::vector<std::uint32_t> place, of;  // #row -> place, #places -> row or none
    std::vector<double> xyz, need, left;   // one coordinate per row; #row
  };
  std::vector<Vec3> at_;
  std::array<Row, scales> rows_;
  std::vector<Vec3> counted_;  // the states under way
  // The longest recent list of states that contains all lists since, and its products. A shorter list is
  // obtained from them by division.
  std::vector<Vec3> all_;
  std::array<std::vector<double>, scales> all_left_;
};

}  // namespace forefeel
