#include "scheduling/motion/recurrent_net.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "geometry/common/error.hpp"
#include "scheduling/motion/past_motion.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/predictors.hpp"
#include "scheduling/motion/trace.hpp"

namespace forefeel {
namespace {

Eigen::VectorXd logistic(const Eigen::VectorXd& x) {
  return (1 + (-x).array().exp()).inverse().matrix();
}

Eigen::VectorXd argument(const RecurrentNet::Gate& gate, const Eigen::VectorXd& input,
                         const Eigen::VectorXd& state) {
  return gate.of_input * input + gate.of_state * state + gate.bias;
}

// The lines of a file of weights by name, each read once.
class NetFile {
 public:
  explicit NetFile(const std::filesystem::path& file) : file_(file) {
    std::ifstream in(file);
    if (!in) throw InputError(file.string(), "cannot be read, expected the weights of a recurrent net");
    for (std::string line; std::getline(in, line);) {
      std::istringstream cells(line);
      std::string name, cell;
      std::getline(cells, name, ',');
      std::vector<double>& values = rows_[name];
      while (std::getline(cells, cell, ',')) {
        char* end = nullptr;
        values.push_back(std::strtod(cell.c_str(), &end));
        if (end == cell.c_str() || !std::isfinite(values.back()))
          throw InputError(file.string(), fmt::format("'{}' in {}, expected a finite number", cell, name));
      }
    }
  }
  const std::vector<double>& row(const std::string& name) const {
    const auto found = rows_.find(name);
    if (found == rows_.end() || found->second.empty())
      throw InputError(file_.string(),
                       fmt::format("no line '{},…', expected the weights of a recurrent net", name));
    return found->second;
  }
  Eigen::MatrixXd matrix(const std::string& name, Eigen::Index rows, Eigen::Index columns) const {
    const std::vector<double>& values = row(name);
    if (static_cast<Eigen::Index>(values.size()) != rows * columns)
      throw InputError(file_.string(),
                       fmt::format("{} has {} values, expected {} x {}", name, values.size(), rows, columns));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(values.data(), rows, columns);
  }

 private:
  std::filesystem::path file_;
  std::map<std::string, std::vector<double>> rows_;
};

constexpr Eigen::Index net_inputs = 2;

}  // namespace

void RecurrentNet::advance(const Eigen::VectorXd& input, Eigen::VectorXd& state) const {
  const Eigen::VectorXd z = logistic(argument(update, input, state)),
                        r = logistic(argument(reset, input, state));
  const Eigen::VectorXd n = argument(next, input, r.cwiseProduct(state)).array().tanh().matrix();
  state += z.cwiseProduct(n - state);
}

RecurrentNet read_recurrent_net(const std::filesystem::path& file) {
  const NetFile weights(file);
  RecurrentNet net;
  net.step = weights.row("step")[0];
  net.unit = weights.row("unit")[0];
  net.horizons = weights.row("horizons");
  const auto size = static_cast<Eigen::Index>(weights.row("bz").size());
  const auto outputs = static_cast<Eigen::Index>(2 * net.horizons.size());
  const auto gate = [&](const std::string& name) {
    return RecurrentNet::Gate{.of_input = weights.matrix("W" + name, size, net_inputs),
                              .of_state = weights.matrix("U" + name, size, size),
                              .bias = weights.matrix("b" + name, size, 1)};
  };
  net.update = gate("z");
  net.reset = gate("r");
  net.next = gate("n");
  net.out = weights.matrix("V", outputs, size);
  net.out_bias = weights.matrix("c", outputs, 1);
  const bool grows = std::ranges::adjacent_find(net.horizons, std::greater_equal<>()) == net.horizons.end();
  if (!(net.step > 0 && net.unit > 0 && net.horizons[0] > 0 && grows))
    throw InputError(file.string(), "expected step, unit and growing horizons above 0");
  return net;
}

// One net serves the three axes, each with a state of its own. Input: the velocity of the axis and the speed, over a
// step, in units. Output, for each horizon s: the way beyond v s and the logarithm of its deviation, both in units s.
// Between the horizons both are interpolated; beyond the last they grow with the horizon.

namespace {

class NetworkPredictor final : public Predictor {
 public:
  explicit NetworkPredictor(RecurrentNet net) : net_(std::move(net)), past_(net_.step, 2) {
    states_.fill(net_.first());
    ahead_.assign(net_.horizons.size(), {});
  }
  void observe(const HipSample& sample) override {
    for (std::size_t n = past_.add(sample); n > 0; --n)
      if (past_.size() > n) advance((past_.back(n - 1) - past_.back(n)) / net_.step);
  }
  Prediction predict(double horizon) const override {
    const double since = past_.since();
    const Prediction then = after(since + horizon), now = after(since);
    return {.horizon = horizon,
            .at = past_.last().at + then.at - now.at,
            .deviation = std::hypot(least, then.deviation)};
  }

 private:
  static constexpr double least = 2e-4;  // [m]

  void advance(const Vec3& velocity) {
    velocity_ = velocity;
    for (Prediction& p : ahead_) p = {};
    for (int k = 0; k < 3; ++k) {
      Eigen::VectorXd& state = states_[static_cast<std::size_t>(k)];
      net_.advance(Eigen::Vector2d(velocity[k], velocity.norm()) / net_.unit, state);
      const Eigen::VectorXd y = net_.output(state);
      const auto count = static_cast<Eigen::Index>(ahead_.size());
      for (Eigen::Index i = 0; i < count; ++i) {
        Prediction& p = ahead_[static_cast<std::size_t>(i)];
        const double scale = net_.unit * net_.horizons[static_cast<std::size_t>(i)];
        p.at[k] = scale * y[i];
        p.deviation =
            std::hypot(p.deviation, scale * std::exp(std::min(y[count + i], 10.0)) / std::sqrt(3.0));
      }
    }
  }
  // Relative to the newest node.
  Prediction after(double horizon) const {
    double before = 0;
    Prediction last;
    for (std::size_t i = 0; i < ahead_.size(); ++i) {
      const double here = net_.horizons[i], w = (horizon - before) / (here - before);
      const Prediction& next = ahead_[i];
      if (horizon <= here || i + 1 == ahead_.size()) {
        const double v = horizon <= here ? w : 1, grown = std::max(horizon / here, 1.0);
        return {.horizon = horizon,
                .at = horizon * velocity_ + grown * (last.at + v * (next.at - last.at)),
                .deviation = grown * (last.deviation + v * (next.deviation - last.deviation))};
      }
      before = here;
      last = next;
    }
    return last;
  }

  RecurrentNet net_;
  PastMotion past_;
  Vec3 velocity_ = Vec3::Zero();
  std::array<Eigen::VectorXd, 3> states_;
  std::vector<Prediction> ahead_;  // beyond v s, at the net's horizons
};

}  // namespace

std::unique_ptr<Predictor> make_network(FactoryContext& context) {
  const std::filesystem::path file = context.arguments.required_text("");
  return std::make_unique<NetworkPredictor>(read_recurrent_net(found_from(context.folder, file)));
}

}  // namespace forefeel
