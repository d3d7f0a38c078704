#include "approx/measured/shared_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace forefeel {
namespace {

constexpr double same = 1e-9;           // of the largest value: two values that differ by less are one
constexpr double off_grid = 0.02;       // of a step, that a value may be off a multiple
constexpr double most_multiples = 1e5;  // a finer grid than this part of the range is none
constexpr std::size_t fewest_gaps = 2;  // that show a step
constexpr double least_noise = 0.02, most_noise = 0.5;  // of rounded forces, in steps
constexpr double by_chance = 0.5;                       // of the noise of means: less is not chance
constexpr double enough_repeated = 0.1;                 // share of the positions
constexpr std::size_t fewest_repeated = 8;

// The step whose multiples all values are; 0: none.
double step_of(std::vector<double> values) {
  std::ranges::sort(values);
  const double range = std::max(std::abs(values.front()), std::abs(values.back()));
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double gap = values[i] - values[i - 1]; gap > same * range) gaps.push_back(gap);
  if (gaps.size() < fewest_gaps) return 0;
  const double step = std::ranges::min(gaps);
  if (step * most_multiples < range) return 0;
  const auto fits = [step](double value) {
    return std::abs(value / step - std::round(value / step)) <= off_grid;
  };
  return std::ranges::all_of(gaps, fits) ? step : 0;
}

}  // namespace

SharedError shared_error(std::span<const State> rows, const RepeatedStates& repeated, double noise) {
  Vec3 step = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const State& row : rows)
      if (row.usable()) values.push_back(row.force[k]);
    if (!values.empty()) step[k] = step_of(std::move(values));
  }
  SharedError found{.step = step.norm()};
  if (noise > least_noise * found.step && noise < most_noise * found.step) found.rounding = 0.5 * found.step;
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(rows, &State::usable));
  const std::size_t positions = usable - std::min(usable, repeated.repeated);
  const bool often = repeated.averaged >= fewest_repeated &&
                     double(repeated.averaged) >= enough_repeated * double(positions);
  if (often && noise < by_chance * repeated.mean_noise) found.courses = repeated.off_mean;
  return found;
}

}  // namespace forefeel
