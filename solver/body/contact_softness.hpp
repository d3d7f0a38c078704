#pragma once
// Estimates how much softer a body is at its contact than the half-space that disc_stiffness() assumes
// (contact_stiffness.hpp). No solve is needed. The body is cut into sections of equal distance s [m] from the patch,
// measured along the mesh, up to the nearest clamp. Its compliance is about
//   c = int ds / (E A) + int (s - s0)^2 ds / (E I)   [m/N]   s0: the mean of s with the weight 1 / I
//   A(s) = dV/ds      area of the section [m^2]
//   I(s) = A lambda   second moment of area [m^4]; lambda: least variance of the section's points [m^2] across the
//                     mean direction of s
// The first integral is the stretch of a rod of varying section. In a half-space, whose sections are hemispheres, it
// is near 1 / k_n. The second integral is the bending of that rod, with no rotation at the patch. Bending makes
// strips, shells and handles softer by orders of magnitude.
// softness = k c, with k the largest stiffness of the disc. Compared with solved bodies (too stiff: the factor by
// which the disc is stiffer than the body):
//                                  softness      too stiff
//   blocks about the patch         0.8 to 2      0.6 to 2      (the liver of the scenes 1.8 and 1.4)
//   columns, twice as high         10            8 to 12
//   ball on a part of its surface  3             3.2
//   strips, 4 to 40 times as long  40 to 1e5     50 to 7e4
//   shells, 3 and 1 mm of 10 cm    4 and 11      9 to 16 and 35 to 60
// The softness tells kinds of bodies apart; it is too inaccurate to be rendered. It ignores the stiffening by a clamp
// near the patch.
//
// The disc is rendered as a first guess only on a block about its patch, where it lies within 0.55 to 1.4
// times the solved stiffness in every direction. 90 blocks of random shape, patch and clamp, phantoms and livers
// were compared with their solves. Each of these conditions excludes some bodies on which the disc was wrong:
//   softness       at most 1.9
//   clamp          broad as seen from the patch, so that the body cannot rock on it: the least standard deviation
//                  of the clamped area, across the line from the patch to its centre, is at least 0.32 of the
//                  distance. Only the part of the clamp within 1.6 times the distance of its nearest node counts
//   depth          to the nearest clamp at least 4 radii of the patch: a thin layer is stiffer than the disc
//   nodes          at least 6 in the contact: a mesh is stiffer about fewer
//   Poisson ratio  at most 0.46 with linear elements, which lock above it
//   material       one within 2 radii of the patch (patch_material())
// Where E varies, A and I above are integrals of E / E_0 over the section, with E_0 at the patch in place of E.

#include <string>

#include "solver/body/body.hpp"

namespace forefeel {

// Infinite where no path leads from the patch to a clamp; 0 without a surface to touch, or where several
// materials lie at the patch.
double contact_softness(const Body& body);

inline constexpr double most_softness = 1.9;

// The least breadth of the clamp, as above; infinite where it lies all around the patch, 0 without a path.
double clamp_breadth(const Body& body);

struct FirstGuess {
  Mat3 stiffness = Mat3::Zero();  // disc_stiffness(), or zero where it is left out [N/m]
  double softness = 0;
  std::string left_out = {};  // why; empty where it is rendered: "the body is about 12 times softer at …"
};
FirstGuess first_guess(const Body& body);

}  // namespace forefeel
