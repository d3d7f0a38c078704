#pragma once
// What a reader must know before any figure of a session: that it is unstable (record/stability.hpp), what no method could answer (a motion that starts
// pressed in, or leaves the box of states) and what makes figures mean less than they say (clamped frames,
// inverted elements, few samples). Console, report.html and summary.json begin with these lines.

#include <cstddef>
#include <string>
#include <vector>

#include "scheduling/record/summary.hpp"

namespace forefeel {

inline constexpr double clamped_too_often = 0.05;  // share of the frames that is said first, as below
inline constexpr double outside_too_often = 0.05;
inline constexpr double long_pause = 0.1;       // of the loop [s]
inline constexpr std::size_t few_samples = 20;  // below this a percentage says less than the count

// One line each, the most serious first; empty where there is nothing to say.
std::vector<std::string> attention(const SessionSummary& summary);

// A share with the number of samples that it rests on: "98.1 % of 213", and "1 of 1" below few_samples;
// "unknown" without samples.
std::string share_of_samples(double share, std::size_t samples);

}  // namespace forefeel
