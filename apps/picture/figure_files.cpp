#include "apps/picture/figure_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "apps/console/command.hpp"
#include "apps/console/suggest.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> drawn_as(const std::string& format, const Figure& figure) {
  const auto& [name, caption, width, height, script] = figure;
  return format == "svg"   ? draw_svg(name, width, height, script)
         : format == "png" ? draw_png(width, height, script)
                           : draw_pdf(width, height, script);
}

}  // namespace

void add_palette(Command& sub, std::string& palette) {
  sub.option("--palette", palette,
             "Colours of the pictures: " + listed(palette_names()) + ", or a list as #0072b2,#d55e00")
      .shows_default();
}

void add_figures(Command& sub, FigureArguments& arguments, const std::string& folder) {
  sub.option("--figures", arguments.formats,
             fmt::format("Also write the figures as files, {}: pdf, png, svg, or several as pdf,png", folder))
      .takes_one()
      .splits_at(',')
      .shows("FORMAT");
  add_palette(sub, arguments.palette);
}

void take_figures(const FigureArguments& arguments) {
  use_palette(arguments.palette);
  for (const std::string& format : arguments.formats)
    if (format != "svg" && format != "png" && format != "pdf")
      throw InputError("--figures",
                       fmt::format("is '{}', expected svg, png, pdf, or several as pdf,png", format));
}

fs::path figures_in(const fs::path& folder) {
  claim_folder(folder / "figures", {"*.pdf", "*.png", "*.svg"});
  return folder / "figures";
}

bool write_figures(const Globals& globals, const fs::path& folder, const std::vector<std::string>& formats,
                   const std::vector<Figure>& figures) {
  bool whole = true;
  for (const std::string& format : formats)
    for (const Figure& figure : figures) {
      const fs::path file = folder / (figure.name + "." + format);
      const auto picture = drawn_as(format, figure);
      if (!picture) {
        warn(globals, file.string() + ": not drawn, gnuplot was not found or failed");
        whole = false;
        continue;
      }
      write_whole(file, *picture);
    }
  return whole;
}

}  // namespace forefeel
