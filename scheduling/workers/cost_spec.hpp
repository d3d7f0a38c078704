#pragma once
// The cost model of the virtual clock, as a typed choice. A command makes it from the user's text
// ("lognormal:0.1,0.5"); to_text() returns that text.
//
//   options.workers.cost = LogNormalCost{.median = 0.1, .sigma = 0.5};
//   options.workers.cost = Registered("mine", {{"gain", "2"}});   // registered with register_cost()

#include <string>
#include <utility>
#include <variant>

#include "scheduling/common/arguments.hpp"

namespace forefeel {

struct ConstantCost {
  double seconds = 0.01;  // [s], above 0, at most 1e6
};
// exp(ln median + sigma n), n standard normal.
struct LogNormalCost {
  double median = 0.01;  // [s], above 0, at most 1e6
  double sigma = 0;      // 0 to 1e6
};
// Log-normal with 95 % between 0.1 and 1 s, clamped to that range ("hundreds of milliseconds to seconds",
// Peterlik and Filipovic 2.2).
struct PaperCost {};
// Drawn from times of solves of this body, measured once and kept in the cache folder.
struct RecordedCost {};

class CostSpec {
 public:
  using Cost = std::variant<ConstantCost, LogNormalCost, PaperCost, RecordedCost, Registered>;

  CostSpec() : CostSpec(ConstantCost{}) {}
  CostSpec(ConstantCost cost) : cost_(cost) {}
  CostSpec(LogNormalCost cost) : cost_(cost) {}
  CostSpec(PaperCost cost) : cost_(cost) {}
  CostSpec(RecordedCost cost) : cost_(cost) {}
  CostSpec(Registered cost) : cost_(std::move(cost)) {}
  // `written` is the user's text; to_text() returns it unchanged.
  CostSpec(Cost cost, std::string written) : cost_(std::move(cost)), written_(std::move(written)) {}

  const Cost& cost() const { return cost_; }
  friend std::string to_text(const CostSpec& cost);

 private:
  Cost cost_;
  std::string written_;
};

std::string to_text(const CostSpec& cost);
// InputError("cost TEXT") for a value outside its range. Measures nothing and does not check registered
// names.
void check(const CostSpec& cost);

}  // namespace forefeel
