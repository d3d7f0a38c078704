#pragma once
// Plots by gnuplot, as SVG, PNG or PDF.

#include <optional>
#include <span>
#include <string>

namespace forefeel {

bool have_gnuplot();
// Runs a script and returns the picture as SVG to embed in an HTML page. Sets the terminal and the output
// itself. `name` makes the ids unique within a page. Returns an empty text if gnuplot is missing or fails.
std::optional<std::string> draw_svg(const std::string& name, int width, int height,
                                    const std::string& script);

// The same as PNG bytes. Nothing if gnuplot is missing, fails, or has no pngcairo.
std::optional<std::string> draw_png(int width, int height, const std::string& script);

// The same as a PDF page of this size in pixels of 1/96 inch.
std::optional<std::string> draw_pdf(int width, int height, const std::string& script);

// Makes text safe inside single quotes of a script: on one line, with quotes doubled. "noenhanced" after the quotes
// keeps '_' and '^' as they are.
std::string plain_text(const std::string& text);

// A data block: "$name << EOD", the lines, "EOD".
std::string data_block(const std::string& name, const std::string& lines);

// Reduces a long curve to what a screen can show: the least and largest value of each of `bins` equal parts,
// in order.
std::string thinned_curve(std::span<const double> x, std::span<const double> y, std::size_t bins);

}  // namespace forefeel
