#pragma once
// The options --palette and --figures, and the figures of a report as files.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/palette.hpp"

namespace forefeel {

class Command;

struct FigureArguments {
  std::string palette{usual_palette};
  std::vector<std::string> formats;  // of the files: svg, png, pdf; empty: none
};

void add_palette(Command& sub, std::string& palette);
// Both options. folder: where the files go, as "DIR/figures".
void add_figures(Command& sub, FigureArguments& arguments, const std::string& folder);

// InputError for an unknown palette or format. From here on, the palette is that of all pictures.
void take_figures(const FigureArguments& arguments);

// FOLDER/figures, made if it is missing. Older pictures in it are removed.
std::filesystem::path figures_in(const std::filesystem::path& folder);

// Writes FOLDER/NAME.FORMAT for each wanted format. If one cannot be written, warns and returns false.
bool write_figures(const Globals& globals, const std::filesystem::path& folder,
                   const std::vector<std::string>& formats, const std::vector<Figure>& figures);

}  // namespace forefeel
