#include "scheduling/workers/cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/error.hpp"
#include "scheduling/common/registry.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {

namespace {
constexpr double longest_solve = 1e6;  // of a solve [s]
constexpr double iterations = 4;       // that a state takes; see cost.hpp
}  // namespace

double CostModel::rest_seconds() const {
  return seconds(Vec3::Zero()) / iterations;
}

namespace {

double checked(double seconds, const std::string& of) {
  if (seconds >= 0 && seconds <= longest_solve) return seconds;
  throw InputError("cost", fmt::format("the cost model charges {} s for {}, expected a time from 0 to {:g} s",
                                       seconds, of, longest_solve));
}

}  // namespace

double checked_seconds(const CostModel& cost, const Vec3& at) {
  const double seconds = cost.seconds(at);
  if (seconds >= 0 && seconds <= longest_solve) return seconds;  // the text below is made only for an error
  return checked(seconds, fmt::format("a state at {:.4g}, {:.4g}, {:.4g} m", at.x(), at.y(), at.z()));
}

double checked_rest_seconds(const CostModel& cost) {
  return checked(cost.rest_seconds(), "the state at rest");
}

namespace {

class ConstantModel final : public CostModel {
 public:
  explicit ConstantModel(double seconds) : seconds_(seconds) {}
  double seconds(const Vec3&) const override { return seconds_; }

 private:
  double seconds_;
};

class LogNormalModel final : public CostModel {
 public:
  LogNormalModel(double median, double sigma, double low, double high, std::uint64_t seed)
      : median_(median), sigma_(sigma), low_(low), high_(high), seed_(seed) {}
  double seconds(const Vec3& at) const override {
    return std::clamp(
        median_ * std::exp(sigma_ * random::normal(random::mix(seed_, random::position_key(at)))), low_,
        high_);
  }

 private:
  double median_, sigma_, low_, high_;
  std::uint64_t seed_;
};

class RecordedModel final : public CostModel {
 public:
  RecordedModel(RecordedCosts measured, std::uint64_t seed)
      : measured_(std::move(measured.solves)), rest_(measured.rest), seed_(seed) {
    std::sort(measured_.begin(), measured_.end());
  }
  // The inverse of the empirical distribution at a random number, linear between the measured times.
  double seconds(const Vec3& at) const override {
    const double place = random::uniform(random::mix(seed_, random::position_key(at))) *
                         static_cast<double>(measured_.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(place), measured_.size() - 1);
    const std::size_t next = std::min(i + 1, measured_.size() - 1);
    const double w = place - static_cast<double>(i);
    return (1 - w) * measured_[i] + w * measured_[next];
  }
  double rest_seconds() const override { return rest_; }

 private:
  std::vector<double> measured_;
  double rest_;
  std::uint64_t seed_;
};

Registry<CostFactory>& cost_registry() {
  static Registry<CostFactory> costs("cost", {}, {"constant", "lognormal", "paper", "recorded"});
  return costs;
}

struct Maker {
  const FactoryContext& context;
  const std::function<RecordedCosts()>& recorded;

  std::unique_ptr<CostModel> operator()(const ConstantCost& cost) const {
    return std::make_unique<ConstantModel>(cost.seconds);
  }
  std::unique_ptr<CostModel> operator()(const LogNormalCost& cost) const {
    return std::make_unique<LogNormalModel>(cost.median, cost.sigma, 1e-9, 1e6, context.seed);
  }
  std::unique_ptr<CostModel> operator()(PaperCost) const {
    const double sigma = std::log(10.0) / (2 * 1.959964);
    return std::make_unique<LogNormalModel>(std::sqrt(0.1), sigma, 0.1, 1.0, context.seed);
  }
  std::unique_ptr<CostModel> operator()(RecordedCost) const {
    RecordedCosts measured = recorded();
    if (measured.solves.empty())
      throw InputError({.key = "cost", .value = "recorded"}, "no solve of this body could be measured");
    return std::make_unique<RecordedModel>(std::move(measured), context.seed);
  }
  std::unique_ptr<CostModel> operator()(const Registered& cost) const {
    const auto factory = cost_registry().find(cost.name);
    if (!factory)
      throw InputError({.key = "cost", .value = to_text(cost)},
                       fmt::format("unknown model, expected {}", cost_kinds()));
    return make_registered(*factory, "cost", cost, context);
  }
};

}  // namespace

void register_cost(const std::string& name, CostFactory factory) {
  cost_registry().add(name, std::move(factory));
}

std::vector<std::string> registered_costs() {
  return cost_registry().names();
}

std::string cost_kinds() {
  const std::vector<std::string> more = registered_costs();
  if (more.empty()) return "constant:SECONDS, lognormal:MEDIAN,SIGMA, recorded or paper";
  return fmt::format("constant:SECONDS, lognormal:MEDIAN,SIGMA, recorded, paper or one of {}",
                     fmt::join(more, ", "));
}

std::unique_ptr<CostModel> make_cost(const CostSpec& cost, const FactoryContext& context,
                                     const std::function<RecordedCosts()>& recorded) {
  check(cost);
  return std::visit(Maker{context, recorded}, cost.cost());
}

}  // namespace forefeel
