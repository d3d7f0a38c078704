#pragma once
// Designs of a state space: places that fill a box about evenly, one for each h^3 of it.
//   lattice        the cubic lattice {k h}^3 through rest
//   body-centred   the lattice of side 2^(1/3) h through rest and the centres of its cubes
//   halton         Halton's sequence in the bases 2, 3 and 5, its digits permuted by the seed (Braaten, Weller 1979;
//                  nested permutations as in Owen 1995)
//   farthest       each next place the one of 16 n Halton places that is farthest from those before it (Gonzalez 1985)
// n = |box| / h^3 places of the last two, at least 1; rest comes first where the box holds it.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

enum class Design : std::uint8_t { lattice, body_centred, halton, farthest };
std::string_view name(Design design);
std::vector<std::string> design_names();  // in the order of the enumeration

// Outward from rest [m].
std::vector<Vec3> designed_places(const Box& box, double spacing, Design design, std::uint64_t seed = 0);

}  // namespace forefeel
