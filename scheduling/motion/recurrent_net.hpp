#pragma once
// A small recurrent net (gated recurrent unit; Cho et al. 2014) whose weights were trained elsewhere:
//   z = g(Wz u + Uz s + bz),  r = g(Wr u + Ur s + br),  n = tanh(Wn u + Un (r s) + bn),  s <- (1 - z) s + z n
//   y = V s + c
// g: logistic function; products of vectors by element; u: input, s: state, zero at first; y: output.
// Its file has a line `name,value,value…` for each of step [s], unit [m/s], horizons [s], Wz, Uz, bz, Wr, Ur, br, Wn,
// Un, bn, V and c, matrices row by row (apps/examples/train_network.py writes one). InputError for other files.

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace forefeel {

struct RecurrentNet {
  struct Gate {
    Eigen::MatrixXd of_input, of_state;  // #state x #inputs, #state x #state
    Eigen::VectorXd bias;
  };
  double step = 0.02, unit = 0.1;  // [s], [m/s]
  std::vector<double> horizons;    // growing [s]
  Gate update, reset, next;        // z, r, n
  Eigen::MatrixXd out;             // V
  Eigen::VectorXd out_bias;        // c

  Eigen::VectorXd first() const { return Eigen::VectorXd::Zero(update.bias.size()); }
  void advance(const Eigen::VectorXd& input, Eigen::VectorXd& state) const;
  Eigen::VectorXd output(const Eigen::VectorXd& state) const { return out * state + out_bias; }
};

RecurrentNet read_recurrent_net(const std::filesystem::path& file);

}  // namespace forefeel
