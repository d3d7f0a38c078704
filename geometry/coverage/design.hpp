#pragma once
// Designs of a state space: places that fill a box about evenly, one for each h^3 of it.
//   lattice        the cubic lattice {k h}^3 through rest
//   body-centred   the lattice of side 2^(1/3) h through rest and the centres of its cubes
//   halton         Halton's sequence in the bases 2, 3 and 5, its digits permuted by the seed (Braaten, Weller 1979;
//                  nested permutations as in Owen 1995)
//   farthest       each next place the one of 16 n Halton places that is farthest from those before it (Gonzalez 1985)
//   error          each next place where the estimated error of the model is largest; needs solved states
//                  (scheduling/placement/placement.hpp), so it cannot be listed here
//   listed         the places of a user, in their order
// n = |box| / h^3 places of halton, farthest and error, at least 1; rest comes first where the box holds it.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

enum class Design : std::uint8_t { lattice, body_centred, halton, farthest, error, listed };
std::string_view name(Design design);
std::vector<std::string> design_names();  // in the order of the enumeration, without `listed`

std::size_t design_size(const Box& box, double spacing);  // n
// Outward from rest [m]; a list keeps its order. InputError("state_space.design") for `error`.
std::vector<Vec3> designed_places(const StateSpaceOptions& space, std::uint64_t seed = 0);
// InputError for a place outside the box, and for two places nearer than the merge distance.
void check_listed(const StateSpaceOptions& space, const std::string& file);

}  // namespace forefeel
