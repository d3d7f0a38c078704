#pragma once
// Estimates the memory that `forefeel generate` needs for a lattice, before anything is solved.

#include "apps/scene/scene.hpp"

namespace forefeel {

// Bytes, within about a third: all positions and their states, and for each coarse node (every second position
// along each axis, and the ends) the displacements of the body and their derivatives.
double bytes_of_lattice(const Scene& scene);
// InputError, with the place of the box, if that is more than bytes_left.
void check_memory_of_lattice(const Scene& scene, double bytes_left);

// Throws InputError if this number of threads (0: all of the machine) needs more memory than is left; each thread has
// its own solver.
void check_memory_of_threads(const Scene& scene, int threads, double bytes_left);

}  // namespace forefeel
