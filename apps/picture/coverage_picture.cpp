#include "apps/picture/coverage_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "apps/picture/coverage_slice.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

constexpr std::array<const char*, 3> axis_name{"x", "y", "z"};
constexpr int panel = slice_panel, legend_height = 150, title_height = 40;

// Room left of each slice for the numbers of its upward axis, below one another with the axis' name.
int margin_of(const CoveragePicture& picture) {
  std::size_t longest = 5;
  for (const int axis : {1, 2})
    for (const double end : {picture.box.low[axis], picture.box.high[axis]})
      longest = std::max(longest, fmt::formatted_size("{:.4g}", 1e3 * end));
  return 54 + 8 * static_cast<int>(longest - 5);
}

std::string legend_line(const CoveragePicture& picture, Label label) {
  const auto i = static_cast<std::size_t>(label);
  double all = 0;
  for (const double v : picture.volume) all += v;
  return fmt::format("{}: {:.4g} cm\u00b3, {:.1f} %, {} component{}", name(label), 1e6 * picture.volume[i],
                     all > 0 ? 100 * picture.volume[i] / all : 0.0, picture.components[i],
                     picture.components[i] == 1 ? "" : "s");
}

// A panel too flat for the name of its upward axis between two numbers has it in the caption.
bool is_flat(double height) {
  return height < 46;
}
std::string caption(const CoveragePicture& picture, const Slice& slice, double height) {
  const auto name_of = [](int axis) { return axis_name[static_cast<std::size_t>(axis)]; };
  return fmt::format("{} = {:.4g} mm{}", name_of(slice.normal), 1e3 * picture.through[slice.normal],
                     is_flat(height) ? fmt::format(", {} \u2191", name_of(slice.v)) : "");
}

// Rectangles of one label: runs along a row, merged with equal runs in the rows above.
void svg_areas(const Slice& slice, double scale, std::string& out) {
  struct Run {
    int from, to, row;
    Label label;
  };
  std::vector<Run> open;
  const auto close = [&](const Run& run, int row) {
    out += fmt::format("<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n",
                       name(run.label), run.from * scale, (slice.rows - row) * scale,
                       (run.to - run.from) * scale, (row - run.row) * scale);
  };
  for (int row = 0; row <= slice.rows; ++row) {
    std::vector<Run> next;
    for (int from = 0; row < slice.rows && from < slice.columns;) {
      int to = from + 1;
      while (to < slice.columns && slice.at(to, row) == slice.at(from, row)) ++to;
      next.push_back({from, to, row, slice.at(from, row)});
      from = to;
    }
    for (const Run& run : open) {
      const auto same = std::ranges::find_if(
          next, [&](const Run& n) { return n.from == run.from && n.to == run.to && n.label == run.label; });
      if (same == next.end()) {
        close(run, row);
      } else {
        same->row = run.row;
      }
    }
    open = std::move(next);
  }
}

void svg_slice(const CoveragePicture& picture, const Slice& slice, double left, double top,
               std::string& out) {
  const double scale = panel / static_cast<double>(std::max(slice.columns, slice.rows));
  const double width = slice.columns * scale, height = slice.rows * scale;
  const auto x_of = [&](double x) { return (x - picture.box.low[slice.u]) / slice.pixel * scale; };
  const auto y_of = [&](double y) { return height - (y - picture.box.low[slice.v]) / slice.pixel * scale; };
  const auto u = static_cast<std::size_t>(slice.u), v = static_cast<std::size_t>(slice.v);
  out += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">\n<text x=\"0\" y=\"-8\">{}</text>\n", left,
                     top + panel - height, caption(picture, slice, height));
  svg_areas(slice, scale, out);
  out += fmt::format("<svg width=\"{0:.1f}\" height=\"{1:.1f}\" viewBox=\"0 0 {0:.1f} {1:.1f}\">\n", width,
                     height);
  if (!slice.states.empty()) {
    const double r = std::clamp(0.09 * picture.spacing / slice.pixel * scale, 0.5, 2.0);
    out += fmt::format("<path class=\"state\" stroke-width=\"{:.2f}\" d=\"", 2 * r);
    for (const auto& s : slice.states) out += fmt::format("M{:.1f} {:.1f}h0", x_of(s.x()), y_of(s.y()));
    out += "\"/>\n";
  }
  if (!slice.outline.empty()) {
    out += "<path class=\"body\" d=\"";
    for (const auto& line : slice.outline)
      out += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", x_of(line[0].x()), y_of(line[0].y()),
                         x_of(line[1].x()), y_of(line[1].y()));
    out += "\"/>\n";
  }
  out += "</svg>\n";
  out += fmt::format("<rect class=\"frame\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n", width, height);
  out += fmt::format(
      "<text x=\"0\" y=\"{0:.1f}\">{2:.4g}</text><text x=\"{1:.1f}\" y=\"{0:.1f}\" "
      "text-anchor=\"end\">{3:.4g} mm</text>"
      "<text x=\"{4:.1f}\" y=\"{0:.1f}\" text-anchor=\"middle\">{5} \u2192</text>\n",
      height + 16, width, 1e3 * picture.box.low[slice.u], 1e3 * picture.box.high[slice.u], width / 2,
      axis_name[u]);
  out += fmt::format(
      "<text x=\"-6\" y=\"{:.1f}\" text-anchor=\"end\">{:.4g}</text><text x=\"-6\" y=\"10\" "
      "text-anchor=\"end\">{:.4g}</text>",
      height, 1e3 * picture.box.low[slice.v], 1e3 * picture.box.high[slice.v]);
  if (!is_flat(height))
    out += fmt::format("<text x=\"-6\" y=\"{:.1f}\" text-anchor=\"end\">{} \u2191</text>", height / 2,
                       axis_name[v]);
  out += "\n</g>\n";
}

std::string states_line(const CoveragePicture& picture, bool too_many) {
  return fmt::format("{} states{}", picture.states.size(),
                     too_many ? " (too many near a slice to draw)" : ", those within h/2 of a slice drawn");
}

}  // namespace

void write_coverage_svg(const std::filesystem::path& file, const CoveragePicture& picture) {
  const int margin = margin_of(picture), width = 3 * panel + 4 * margin;
  const int height = title_height + panel + 34 + legend_height;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<title>{2}</title>\n<defs>\n",
      width, height, html_escaped(picture.title));
  // Hatching repeats the meaning of the colour: diagonal lines for gap, horizontal ones for sparse. Only
  // states are drawn as dots.
  out += fmt::format(
      "<pattern id=\"sparse\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\"><rect width=\"8\" "
      "height=\"8\" fill=\"{0}\"/>"
      "<path d=\"M0 4H8\" stroke=\"#1b1b1b\" stroke-opacity=\"0.35\" stroke-width=\"0.7\"/></pattern>\n"
      "<pattern id=\"gap\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\"><rect width=\"7\" "
      "height=\"7\" fill=\"{1}\"/>"
      "<path d=\"M-1 8L8 -1M-1 1L1 -1M6 8L8 6\" stroke=\"#1b1b1b\" stroke-opacity=\"0.55\" "
      "stroke-width=\"0.9\"/></pattern>\n</defs>\n",
      colour(Label::sparse), colour(Label::gap));
  out += fmt::format(
      "<style>.safe{{fill:{}}}.sparse{{fill:url(#sparse)}}.gap{{fill:url(#gap)}}.blank{{fill:{}}}"
      ".state{{stroke:#000;stroke-linecap:round;fill:none;stroke-opacity:.75}}.body{{stroke:#c02020;stroke-"
      "width:1.4;fill:none}}"
      ".frame{{fill:none;stroke:#444;stroke-width:.8}}</style>\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n",
      colour(Label::safe), colour(Label::blank));
  out += fmt::format("<text x=\"{}\" y=\"20\" font-size=\"14\">{}</text>\n", margin,
                     html_escaped(picture.title));
  bool too_many = false;
  for (int i = 0; i < 3; ++i) {
    const Slice slice = cut(picture, 2 - i);
    too_many = too_many || slice.too_many_states;
    svg_slice(picture, slice, margin + i * (panel + margin), title_height + 10, out);
  }
  const int top = title_height + panel + 54;
  for (int i = 0; i < 4; ++i) {
    const auto label = static_cast<Label>(i);
    out += fmt::format(
        "<rect class=\"{0}\" x=\"{1}\" y=\"{2}\" width=\"26\" height=\"15\"/><rect class=\"frame\" x=\"{1}\" "
        "y=\"{2}\" "
        "width=\"26\" height=\"15\"/><text x=\"{3}\" y=\"{4}\">{5}</text>\n",
        name(label), margin, top + 22 * i, margin + 34, top + 22 * i + 12, legend_line(picture, label));
  }
  out += fmt::format(
      "<path class=\"state\" stroke-width=\"3\" d=\"M{} {}h0\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
      margin + panel + margin + 13, top + 8, margin + panel + margin + 34, top + 12,
      states_line(picture, too_many));
  if (!picture.body.empty())
    out += fmt::format("<path class=\"body\" d=\"M{} {}h26\"/><text x=\"{}\" y=\"{}\">body at rest</text>\n",
                       margin + panel + margin, top + 30, margin + panel + margin + 34, top + 34);
  out += "</svg>\n";
  OutputFile target(file);
  target.write(out);
  target.commit();
}

namespace {

// The PNG is the SVG drawn by gnuplot: one canvas in the same pixels, y downwards, with the same texts.

std::array<int, 3> rgb(Label label) {
  unsigned value = 0;
  std::sscanf(std::string(colour(label)).c_str() + 1, "%x", &value);
  return {static_cast<int>(value >> 16 & 255), static_cast<int>(value >> 8 & 255),
          static_cast<int>(value & 255)};
}

// Colour of a pixel, hatched as in the SVG: #1b1b1b laid over the label's colour.
std::array<int, 3> ink_at(Label label, int x, int y) {
  const double dark = label == Label::gap && (x + y) % 7 == 0 ? 0.5
                      : label == Label::sparse && y % 8 == 4  ? 0.25
                                                              : 0.0;
  std::array<int, 3> c = rgb(label);
  for (int& part : c) part = static_cast<int>(std::lround((1 - dark) * part + dark * 0x1b));
  return c;
}

struct Canvas {
  std::string data, plots, decorations;
  int images = 0;

  // Pixels of a rectangle; label_at(x, y) from its top left corner.
  template <class LabelAt>
  void image(double left, double top, int width, int height, LabelAt label_at) {
    data += fmt::format("$image{} << EOD\n", images);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto c = ink_at(label_at(x, y), x, y);
        data += fmt::format("{:.1f} {:.1f} {} {} {}\n", left + x + 0.5, top + y + 0.5, c[0], c[1], c[2]);
      }
    data += "EOD\n";
    plots +=
        fmt::format("{}$image{} using 1:2:3:4:5 with rgbimage", plots.empty() ? "plot " : ", ", images++);
  }
  void frame(double left, double top, double width, double height) {
    decorations += fmt::format(
        "set object rectangle from {:.1f},{:.1f} to {:.1f},{:.1f} front fs empty border lc rgb "
        "'#444444' lw 0.8\n",
        left, top, left + width, top + height);
  }
  // x, y: of the base line, as in an SVG.
  void text(double x, double y, const char* anchor, const std::string& words, int points = 9) {
    decorations += fmt::format("set label '{}' at {:.1f},{:.1f} {} noenhanced font 'sans,{}' front\n",
                               plain_text(words), x, y - 4, anchor, points);
  }
};

// The part of a line inside [0, width] x [0, height]; nothing outside.
std::optional<std::array<Eigen::Vector2d, 2>> clipped(std::array<Eigen::Vector2d, 2> line, double width,
                                                      double height) {
  const Eigen::Vector2d a = line[0], d = line[1] - line[0];
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double most = axis == 0 ? width : height;
    if (d[axis] == 0) {
      if (a[axis] < 0 || a[axis] > most) return {};
      continue;
    }
    const double one = -a[axis] / d[axis], two = (most - a[axis]) / d[axis];
    from = std::max(from, std::min(one, two));
    to = std::min(to, std::max(one, two));
  }
  if (from >= to) return {};
  return std::array<Eigen::Vector2d, 2>{Eigen::Vector2d(a + from * d), Eigen::Vector2d(a + to * d)};
}

void png_marks(const CoveragePicture& picture, const Slice& slice, double left, double top, double scale,
               Canvas& canvas) {
  const double width = slice.columns * scale, height = slice.rows * scale;
  const auto placed = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d((p.x() - picture.box.low[slice.u]) / slice.pixel * scale,
                           height - (p.y() - picture.box.low[slice.v]) / slice.pixel * scale);
  };
  std::string states, body;
  for (const Eigen::Vector2d& state : slice.states) {
    const Eigen::Vector2d p = placed(state);
    states += fmt::format("{:.1f} {:.1f}\n", left + p.x(), top + p.y());
  }
  for (const auto& line : slice.outline)
    if (const auto part = clipped({placed(line[0]), placed(line[1])}, width, height))
      body += fmt::format("{:.1f} {:.1f}\n{:.1f} {:.1f}\n\n", left + (*part)[0].x(), top + (*part)[0].y(),
                          left + (*part)[1].x(), top + (*part)[1].y());
  const double r = std::clamp(0.09 * picture.spacing / slice.pixel * scale, 0.5, 2.0);
  if (!states.empty()) {
    canvas.data += data_block(fmt::format("states{}", slice.normal), states);
    canvas.plots += fmt::format(
        ", $states{} using 1:2:({:.2f}) with circles fs solid noborder lc rgb '#202020'", slice.normal, r);
  }
  if (!body.empty()) {
    canvas.data += data_block(fmt::format("body{}", slice.normal), body);
    canvas.plots += fmt::format(", $body{} with lines lw 1.4 lc rgb '#c02020'", slice.normal);
  }
}

void png_slice(const CoveragePicture& picture, const Slice& slice, double left, double below,
               Canvas& canvas) {
  const double scale = panel / static_cast<double>(std::max(slice.columns, slice.rows));
  const double width = slice.columns * scale, height = slice.rows * scale, top = below + panel - height;
  const auto name_of = [](int axis) { return std::string(axis_name[static_cast<std::size_t>(axis)]); };
  canvas.image(left, top, std::max(1, static_cast<int>(std::lround(width))),
               std::max(1, static_cast<int>(std::lround(height))), [&](int x, int y) {
                 const int column = std::min(slice.columns - 1, static_cast<int>((x + 0.5) / scale)),
                           row =
                               slice.rows - 1 - std::min(slice.rows - 1, static_cast<int>((y + 0.5) / scale));
                 return slice.at(column, row);
               });
  png_marks(picture, slice, left, top, scale, canvas);
  canvas.frame(left, top, width, height);
  const auto mm = [](double metres) { return fmt::format("{:.4g}", 1e3 * metres); };
  canvas.text(left, top - 8, "left", caption(picture, slice, height));
  canvas.text(left, top + height + 16, "left", mm(picture.box.low[slice.u]));
  canvas.text(left + width, top + height + 16, "right", mm(picture.box.high[slice.u]) + " mm");
  canvas.text(left + width / 2, top + height + 16, "center", name_of(slice.u) + " \u2192");
  canvas.text(left - 6, top + height, "right", mm(picture.box.low[slice.v]));
  canvas.text(left - 6, top + 10, "right", mm(picture.box.high[slice.v]));
  if (!is_flat(height)) canvas.text(left - 6, top + height / 2, "right", name_of(slice.v) + " \u2191");
}

void png_legend(const CoveragePicture& picture, bool too_many, Canvas& canvas) {
  const int margin = margin_of(picture);
  const double top = title_height + panel + 54, right = margin + panel + margin;
  for (int i = 0; i < 4; ++i) {
    const auto label = static_cast<Label>(i);
    canvas.image(margin, top + 22 * i, 26, 15, [label](int, int) { return label; });
    canvas.frame(margin, top + 22 * i, 26, 15);
    canvas.text(margin + 34, top + 22 * i + 12, "left", legend_line(picture, label));
  }
  canvas.data += data_block("dot", fmt::format("{} {}\n", right + 13, top + 8));
  canvas.plots += ", $dot using 1:2:(1.5) with circles fs solid noborder lc rgb '#202020'";
  canvas.text(right + 34, top + 12, "left", states_line(picture, too_many));
  if (picture.body.empty()) return;
  canvas.data += data_block("red", fmt::format("{0} {2}\n{1} {2}\n", right, right + 26, top + 30));
  canvas.plots += ", $red with lines lw 1.4 lc rgb '#c02020'";
  canvas.text(right + 34, top + 34, "left", "body at rest");
}

}  // namespace

void write_coverage_drawn(const std::filesystem::path& file, const CoveragePicture& picture) {
  if (!have_gnuplot())
    throw InputError({.file = file.string()}, "a PNG or PDF needs gnuplot, which is missing; expected .svg");
  check_writable(file);
  const int margin = margin_of(picture), width = 3 * panel + 4 * margin;
  const int height = title_height + panel + 34 + legend_height;
  Canvas canvas;
  canvas.text(margin, 20, "left", picture.title, 10);
  bool too_many = false;
  for (int i = 0; i < 3; ++i) {
    const Slice slice = cut(picture, 2 - i);
    too_many = too_many || slice.too_many_states;
    png_slice(picture, slice, margin + i * (panel + margin), title_height + 10, canvas);
  }
  png_legend(picture, too_many, canvas);
  const std::string script =
      canvas.data + canvas.decorations +
      fmt::format(
          "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at screen "
          "1\nunset border\nunset tics\nunset key\nset xrange [0:{}]\nset yrange [{}:0]\n",
          width, height) +
      canvas.plots + "\n";
  const std::optional<std::string> picture_bytes =
      file.extension() == ".pdf" ? draw_pdf(width, height, script) : draw_png(width, height, script);
  if (!picture_bytes)
    throw InputError({.file = file.string()}, "gnuplot could not draw it, expected one with cairo, or .svg");
  OutputFile out(file);
  out.write(*picture_bytes);
  out.commit();
}

}  // namespace forefeel
