#pragma once
// Options of the body's shape: displacements u [m] at a given rate, in addition to the force that the loop renders.

#include <cstddef>

namespace forefeel {

struct ShapeOptions {
  double rate = 0;              // shapes per second [Hz]; 0: none, at no cost
  bool surface = true;          // nodes of the surface alone; false: of the whole body
  std::size_t checks = 20;      // shapes compared with tight solves after the run
  std::size_t neighbours = 32;  // states that a shape is interpolated from
};

// Throws InputError with the key of an invalid value, as "session.shape_rate".
void check(const ShapeOptions& options);

}  // namespace forefeel
