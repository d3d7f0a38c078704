#pragma once
// Fixed directions along which NeighbourSelector looks for the sides of a gap.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel::detail {

// 256 directions, evenly spread over the sphere (golden-angle spiral), each with its opposite. A grid on the faces of
// a cube divides the directions into cells. Each cell lists the directions whose angle to some direction in the cell
// is at most arccos(turned).
class Views {
 public:
  static constexpr double turned =
      0.93;  // cosine within which a state's own view is blended from the fixed ones

  Views();
  // Number of the cell that the direction u lies in; cells x cells on each of the six faces.
  static std::size_t cell_of(const Vec3& u, int cells);
  // Indices of the directions near u.
  std::span<const std::uint16_t> of(const Vec3& u) const;

  std::vector<Vec3> all;

 private:
  static constexpr int pairs = 128, grid = 16;
  std::vector<std::uint16_t> about_;
  std::vector<std::size_t> first_;  // in about_, of each cell
};

const Views& views();

}  // namespace forefeel::detail
