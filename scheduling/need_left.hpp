#pragma once
// What places still need once the states that are being solved are there:
//   left_s(q) = need_s(q) prod_p (1 - m_s(q, p)),    m_s(q, p) = (1 - |q - p|^2 inverse_s)_+
// over the states p under way, in their order, for each scale s. Kept from one call to the next: a state more costs
// one pass over the places, and so does leaving out a few of many.

#include <array>
#include <span>
#include <vector>

#include "geometry/types.hpp"

namespace forefeel {

class NeedLeft {
 public:
  static constexpr std::size_t scales = 3;
  using Needs = std::array<double, scales>;

  // New places with their needs, nothing under way; inverses [1/m^2].
  void begin(std::span<const Vec3> at, std::span<const Needs> needs, const Needs& inverses);
  // Accounts for these and no others.
  void set(std::span<const Vec3> under_way);

  std::size_t places() const { return xyz_.size() / 3; }
  Vec3 at(std::size_t i) const { return {xyz_[i], xyz_[places() + i], xyz_[2 * places() + i]}; }
  Needs left(std::size_t i) const { return {left_[i], left_[places() + i], left_[2 * places() + i]}; }
  std::span<const Vec3> under_way() const { return counted_; }

 private:
  void multiply(const Vec3& p);
  void anew(std::span<const Vec3> under_way);
  bool leave_out(std::span<const Vec3> under_way);

  std::vector<double> xyz_, needs_, left_;   // a coordinate or scale a row, #places
  Needs inverses_{};
  std::vector<Vec3> counted_;                // what left_ accounts for
  std::vector<double> all_left_;             // of the longest list lately, from which some may be left out
  std::vector<Vec3> all_;
};

}  // namespace forefeel
