#pragma once
// The inner loops of a model of energy jets (approx/model/jet_set.hpp): a blend of the energies E_i of n states,
//   E(x) = sum_i w_i E_i(d_i),   d_i = x - x_i,   w_i = v_i / sum_j v_j,   v_i = 1 / Q_i^2
//   E_i(d) = E_0 - f_0 . d + 1/2 d^T K d + S_3 E_3(d) + S_4 E_4(d) + S_5 E_5(d)              [J]
//   q_i    = own estimate squared: a_5 |grad E_5|^2 + a_4 |grad E_4|^2 + a_3 |grad E_3|^2 + e_0^2   [N^2]
//   Q_i    = q_i (1 + c max(0, |d|^2 / t^2 - 1)^3)     t: trust [m], c: distrust
// with gradient and Hessian, those of the weights included. S_k(|d|) is 1 up to the radius R of a jet. Beyond it the
// term grows ever more slowly, from 2 R on linearly: S_k |d|^k = h_k,
//   h_k = R^k (1 + k s / R + k (k - 1) g(s) / R^2),  s = |d| - R,  g'' = max(0, 1 - s / R)^2, g(0) = g'(0) = 0
// Each lane of a vector is a jet; padding has a large e_0. Compiled for several instruction sets (instruction_set.hpp).
// The third derivatives T of a form of degree k give the others (Euler): H = T d / (k - 2), grad = H d / (k - 1),
// E = grad . d / k.

#include <cstddef>

namespace forefeel::jets {

inline constexpr std::size_t lanes = 8;  // jets in a block
// Rows of a block, each of `lanes` values. Coefficients e_abc are stored as derivatives, a! b! c! e_abc.
enum Row : std::size_t {
  row_at = 0,       // x_i, 3 [m]
  row_energy = 3,   // E_0 less that of the model's reference [J]
  row_slope = 4,    // -f_0, 3 [N]
  row_bend = 7,     // K: xx yy zz xy xz yz [N/m]
  row_third = 13,   // 10
  row_fourth = 23,  // 15
  row_fifth = 38,   // 21
  row_shares = 59,  // a_3, a_4, a_5
  row_floor = 62,   // e_0^2 [N^2]
  row_trust = 63,   // 1 / t^2 [1/m^2]
  row_growth = 64,  // c
  row_radius = 65,  // R [m]
  rows = 66
};
inline constexpr std::size_t block_size = rows * lanes;
inline constexpr std::size_t estimate_rows = 6;
inline constexpr std::size_t most_blocks = 8;

struct Blend {
  double energy = 0, gradient[3] = {}, hessian[6] = {};  // [J], [N], [N/m]: xx yy zz xy xz yz
  double estimate = 0;                                   // sqrt of sum_i w_i Q_i [N]
  double spread = 0;                                     // sqrt of sum_i w_i |grad E_i - grad E|^2 [N]
  double mixing = 0;     // size of the part of the gradient that comes from the weights [N]
  double confirmed = 0;  // sum of the w_i with |d_i| <= t_i
};

struct Loops {
  // blocks: at most most_blocks, one after the other.
  void (*blend)(std::size_t blocks, const double* data, const double x[3], Blend& out);
  // Of each lane of one block at x: q, Q, the force f = -grad E_i and E_i, `estimate_rows` rows of `lanes`.
  void (*estimates)(const double* block, const double x[3], double* out);
};
const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::jets
