#pragma once
// Who solved what when: one row a worker, one bar a solve, coloured by the label of the region it was meant
// for.

#include <string>

#include "apps/picture/report_figures.hpp"
#include "scheduling/log/session_result.hpp"

namespace forefeel {

// Bars of cancelled solves are thin, bars of states that no model took are half as high. Below: the label at
// the HIP.
Figure gantt_figure(const SessionResult& result, double seconds, int workers);

}  // namespace forefeel
