#pragma once
// Slices through labelled regions in three directions, with states, the outline of a body and a legend. The
// four colours differ in luminance and carry hatching, so they can be told apart in grey print and with
// colour blindness.

#include <filesystem>

#include "apps/picture/coverage_slice.hpp"

namespace forefeel {

// .svg; or .png or .pdf by gnuplot, InputError if it is missing.
void write_coverage_picture(const std::filesystem::path& file, const CoveragePicture& picture);

}  // namespace forefeel
