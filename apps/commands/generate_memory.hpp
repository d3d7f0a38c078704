#pragma once
// The memory that `forefeel generate` takes for a lattice, asked before anything is solved.

#include "apps/scene_input/scene.hpp"

namespace forefeel {

// Bytes, within about a third: all positions and their states, and for each coarse node (every eighth position)
// the displacements of the body and their derivatives.
double bytes_of_lattice(const Scene& scene);
// InputError at the box where that is more than is left.
void check_memory_of_lattice(const Scene& scene, double bytes_left);

// Throws InputError where so many threads (0: as many as the machine has) would take more memory than is
// left: each has a solver of its own.
void check_memory_of_threads(const Scene& scene, int threads, double bytes_left);

}  // namespace forefeel
