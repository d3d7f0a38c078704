#pragma once
// Warnings that a reader needs before the figures of a session, because they change what one does: a tip that drags its
// site out of what is known, instability (record/stability.hpp), the distance from measured states, a mesh whose own
// error a hand would feel, many clamped frames, a motion that starts pressed in or leaves the box of states with errors
// that a hand could feel, inverted elements, few samples. Console, report.html and summary.json begin with these lines.
// The same matters below what a hand feels are remarks, among the notes.

#include <cstddef>
#include <string>
#include <vector>

#include "scheduling/record/summary.hpp"

namespace forefeel {

inline constexpr double clamped_too_often = 0.05;  // share of the frames above which it is reported
inline constexpr double outside_too_often = 0.05;  // of the box of states, or of what a touch knows
inline constexpr double added_too_much = 0.01;     // force error of passivity control, p95 [1]
inline constexpr double held_too_much = 1e-3;   // hold energy above which an unstable session mentions it [J]
inline constexpr double long_pause = 0.1;       // of the loop [s]
inline constexpr std::size_t few_samples = 20;  // with fewer samples, counts are printed, not percentages

// One line each, the most serious first; empty if there are no warnings.
std::vector<std::string> attention(const SessionSummary& summary);

// What is as it should be and still worth a note: the error of the mesh, a box that the motion leaves without error.
std::vector<std::string> remarks(const SessionSummary& summary);
// The motion leaves the box of states so often that errors there could be felt: of what it was outside, less than nine
// tenths are known to be right.
bool outside_is_felt(const SessionSummary& summary);

// A share with the number of samples that it rests on: "98.1 % of 213", and "1 of 1" below few_samples;
// "unknown" without samples.
std::string share_of_samples(double share, std::size_t samples);

}  // namespace forefeel
