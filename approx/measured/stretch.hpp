#pragma once
// Lengths that differ by direction. A body pressed from above changes its force quicker with depth than along it, and a
// law of one length, which rows along many lines determine, is then sure of what lies between two depths. With A
// symmetric, of determinant 1, in the principal directions of the rows:
//   cov(g_c(x), g_c(x')) = a^2 r(|A (x - x')| / l)
// A is found by steps of a factor in one direction at a time, as long as they raise the likelihood.

#include "approx/measured/gaussian_process.hpp"

namespace forefeel {

// The rows at A x.
MeasuredRows stretched(MeasuredRows rows, const Mat3& by);

// A; the identity if it is not surely likelier. A direction in which the rows deviate by less than a twentieth of their
// largest deviation tells nothing and keeps its length. Some thirty searches of improved_law().
Mat3 likely_stretch(const MeasuredRows& rows, const FieldLaw& law, std::optional<double> noise);

}  // namespace forefeel
