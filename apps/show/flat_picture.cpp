#include "apps/show/flat_picture.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel {

void FlatPicture::polygon(std::vector<Vec2> corners, const std::string& colour, double opacity) {
  for (const Vec2& corner : corners)
    if (!corner.allFinite()) return;
  polygons_.push_back({std::move(corners), colour, opacity});
}

void FlatPicture::line(const Vec2& from, const Vec2& to, double width, const std::string& colour,
                       double opacity) {
  Vec2 along = to - from;
  if (along.norm() < 1e-9) along = Vec2(1, 0);
  const Vec2 side = 0.5 * width * Vec2(-along.y(), along.x()).normalized();
  polygon({from + side, to + side, to - side, from - side}, colour, opacity);
}

void FlatPicture::dot(const Vec2& at, double radius, const std::string& colour, double opacity) {
  std::vector<Vec2> corners;
  constexpr int n = 10;
  for (int k = 0; k < n; ++k)
    corners.emplace_back(
        at + radius * Vec2(std::cos(2 * std::numbers::pi * k / n), std::sin(2 * std::numbers::pi * k / n)));
  polygon(std::move(corners), colour, opacity);
}

void FlatPicture::text(const Vec2& at, const std::string& words, int size, const std::string& colour) {
  texts_.push_back({at, words, size, colour});
}

std::string FlatPicture::svg(const std::string& title) const {
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Helvetica,Arial,sans-serif\">\n<title>{2}</title>\n<rect width=\"{0}\" height=\"{1}\" "
      "fill=\"#ffffff\"/>\n",
      width_, height_, html_escaped(title));
  for (const Polygon& p : polygons_) {
    out += "<path d=\"";
    for (std::size_t i = 0; i < p.corners.size(); ++i)
      out += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', p.corners[i].x(), p.corners[i].y());
    // A hairline of its own colour closes the seam between opaque neighbours.
    out += fmt::format("Z\" fill=\"{}\"", p.colour);
    out += p.opacity < 1 ? fmt::format(" fill-opacity=\"{:.2f}\"/>\n", p.opacity)
                         : fmt::format(" stroke=\"{}\" stroke-width=\"0.4\"/>\n", p.colour);
  }
  for (const Text& t : texts_)
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{}\" fill=\"{}\">{}</text>\n", t.at.x(),
                       t.at.y(), t.size, t.colour, html_escaped(t.words));
  return out + "</svg>\n";
}

std::optional<std::string> FlatPicture::png() const {
  std::string script = fmt::format(
      "unset border\nunset tics\nunset key\nset margins 0,0,0,0\nset xrange [0:{}]\nset yrange [{}:0]\n",
      width_, height_);
  std::size_t number = 0;
  for (const Polygon& p : polygons_) {
    script += fmt::format("set object {} polygon from ", ++number);
    for (const Vec2& corner : p.corners) script += fmt::format("{:.2f},{:.2f} to ", corner.x(), corner.y());
    script += fmt::format("{:.2f},{:.2f} front fs {} fc rgb '{}'\n", p.corners[0].x(), p.corners[0].y(),
                          p.opacity < 1 ? fmt::format("transparent solid {:.2f} noborder", p.opacity)
                                        : fmt::format("solid border lc rgb '{}' lw 0.8", p.colour),
                          p.colour);
  }
  for (const Text& t : texts_) {
    std::string words;
    for (const char c : t.words) words += c == '"' || c == '\\' || c == '\n' ? ' ' : c;
    script += fmt::format("set label \"{}\" at {:.2f},{:.2f} front font ',{}' textcolor rgb '{}'\n", words,
                          t.at.x(), t.at.y() - 0.35 * t.size, 0.75 * t.size, t.colour);
  }
  return draw_png(width_, height_, script + "plot NaN notitle\n");
}

}  // namespace forefeel
