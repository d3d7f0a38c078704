#pragma once
// A figure of a report: a gnuplot script (plot.hpp) with its caption, and the tables beside it.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/picture/palette.hpp"

namespace forefeel {

struct Figure {
  std::string name;  // prefix of its ids, and name of its file without extension
  std::string caption;
  int width = 960, height = 420;
  std::string script;
};

extern const char* const plot_style;  // gnuplot style of axes, tics and grid

// Writes NAME.svg into the folder and returns a <figure> with it; without gnuplot, a note instead.
std::string draw_into(const std::filesystem::path& folder, const Figure& figure);
// HTML table of rows of cells; the first row is the header. Escapes the text.
std::string html_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace forefeel
