#include "scheduling/workers/cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "geometry/common/error.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {

namespace {
constexpr double iterations = 4;  // of a state (cost.hpp)
}  // namespace

double CostModel::rest_seconds() const {
  return seconds(Vec3::Zero()) / iterations;
}

namespace {

class ConstantCost final : public CostModel {
 public:
  explicit ConstantCost(double seconds) : seconds_(seconds) {}
  double seconds(const Vec3&) const override { return seconds_; }

 private:
  double seconds_;
};

class LogNormalCost final : public CostModel {
 public:
  LogNormalCost(double median, double sigma, double low, double high, std::uint64_t seed)
      : median_(median), sigma_(sigma), low_(low), high_(high), seed_(seed) {}
  double seconds(const Vec3& at) const override {
    return std::clamp(median_ * std::exp(sigma_ * normal(mix(seed_, position_key(at)))), low_, high_);
  }

 private:
  double median_, sigma_, low_, high_;
  std::uint64_t seed_;
};

class RecordedCost final : public CostModel {
 public:
  RecordedCost(RecordedCosts measured, std::uint64_t seed)
      : measured_(std::move(measured.solves)), rest_(measured.rest), seed_(seed) {
    std::sort(measured_.begin(), measured_.end());
  }
  // Inverse of the empirical distribution, linear between the measured times.
  double seconds(const Vec3& at) const override {
    const double place = uniform(mix(seed_, position_key(at))) * static_cast<double>(measured_.size() - 1);
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

double number(const std::string& spec, std::string_view text, double low, bool open) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < low ||
      value > 1e6 || (open && value == low))
    throw InputError({.key = "cost", .value = spec}, fmt::format("'{}' is not a number {} {} and at most 1e6",
                                                                 text, open ? "above" : "of at least", low));
  return value;
}

std::unique_ptr<CostModel> parse(const std::string& spec, std::uint64_t seed) {
  const std::size_t colon = spec.find(':');
  const std::string kind = spec.substr(0, colon),
                    arguments = colon == std::string::npos ? "" : spec.substr(colon + 1);
  if (kind == "constant") return std::make_unique<ConstantCost>(number(spec, arguments, 0, true));
  if (kind == "lognormal") {
    const std::size_t comma = arguments.find(',');
    if (comma == std::string::npos)
      throw InputError({.key = "cost", .value = spec}, "expected lognormal:MEDIAN,SIGMA");
    const double median = number(spec, std::string_view(arguments).substr(0, comma), 0, true);
    const double sigma = number(spec, std::string_view(arguments).substr(comma + 1), 0, false);
    return std::make_unique<LogNormalCost>(median, sigma, 1e-9, 1e6, seed);
  }
  if (spec == "paper") {
    const double sigma = std::log(10.0) / (2 * 1.959964);
    return std::make_unique<LogNormalCost>(std::sqrt(0.1), sigma, 0.1, 1.0, seed);
  }
  if (spec == "recorded") return nullptr;
  throw InputError({.key = "cost", .value = spec},
                   "unknown model, expected constant:SECONDS, lognormal:MEDIAN,SIGMA, recorded or paper");
}

}  // namespace

std::unique_ptr<CostModel> make_cost(const std::string& spec, std::uint64_t seed,
                                     const std::function<RecordedCosts()>& recorded) {
  if (auto model = parse(spec, seed)) return model;
  RecordedCosts measured = recorded();
  if (measured.solves.empty())
    throw InputError({.key = "cost", .value = "recorded"}, "no solve of this body could be measured");
  return std::make_unique<RecordedCost>(std::move(measured), seed);
}

void check_cost(const std::string& spec) {
  parse(spec, 0);
}

}  // namespace forefeel
