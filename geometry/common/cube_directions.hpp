#pragma once
// Unit vectors to the faces, edges and corners of a cube.

#include <array>
#include <cstddef>

#include "geometry/common/types.hpp"

namespace forefeel {

inline constexpr std::size_t cube_direction_count = 26;

inline const std::array<Vec3, cube_direction_count>& cube_directions() {
  static const std::array<Vec3, cube_direction_count> all = [] {
    std::array<Vec3, cube_direction_count> made;
    std::size_t count = 0;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x != 0 || y != 0 || z != 0) made[count++] = Vec3(x, y, z).normalized();
    return made;
  }();
  return all;
}

}  // namespace forefeel
