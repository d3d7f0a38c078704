#pragma once
// The script of a session's report: curves over time that can be zoomed and read off, a view around each
// switch, and maps of where errors were. It needs no other file and no network.

#include <string_view>

namespace forefeel {

// JavaScript in two parts; concatenated, they are one function. It reads the document of run_data.hpp from the element
// "run-data" and draws into the elements that run_charts() of run_charts.hpp makes.
extern const std::string_view run_script_chart, run_script_page;

}  // namespace forefeel
