#include "apps/picture/figure.hpp"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {

namespace fs = std::filesystem;

const char* const plot_style = R"(
set border 3 lc rgb '#8a8a8a' lw 0.8
set tics nomirror out scale 0.5 textcolor rgb '#3a3a3a'
set grid lc rgb '#e4e1da' lw 0.7
)";

std::string draw_into(const fs::path& folder, const Figure& figure) {
  const std::optional<std::string> svg = draw_svg(figure.name, figure.width, figure.height, figure.script);
  if (!svg) return "<p class=\"note\">A picture is missing: gnuplot was not found or failed.</p>\n";
  write_whole(folder / (figure.name + ".svg"), *svg + "\n");
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", *svg, html_escaped(figure.caption));
}

std::string html_table(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table>";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    html += "<tr>";
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      const bool head = i == 0;
      const bool figure = j > 0 && !rows[i][j].empty() &&
                          std::string_view("0123456789+-").find(rows[i][j][0]) != std::string_view::npos;
      html += head ? "<th>" : figure ? "<td class=\"n\">" : "<td>";
      html += html_escaped(rows[i][j]) + (head ? "</th>" : "</td>");
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

}  // namespace forefeel
