#include "apps/picture/coverage_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "apps/console/units.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

constexpr std::array<const char*, 3> axis_name{"x", "y", "z"};
constexpr int panel = slice_panel, legend_height = 150, title_height = 40;

// What the picture is drawn on, in pixels, y downwards. x, y of a text: its base line.
class Canvas {
 public:
  enum class Anchor { left, middle, right };
  virtual ~Canvas() = default;
  // The labels of a slice, then its states and the outline of the body.
  virtual void slice(const Slice& slice, double left, double top, double scale) = 0;
  virtual void swatch(Label label, double left, double top, double width, double height) = 0;
  virtual void state(double x, double y) = 0;  // of the legend, as the outline
  virtual void outline(double x, double y, double length) = 0;
  virtual void frame(double left, double top, double width, double height) = 0;
  virtual void text(double x, double y, Anchor anchor, const std::string& words, bool large = false) = 0;
};
using Anchor = Canvas::Anchor;

double radius_of(const Slice& slice, double scale) {
  return std::clamp(slice.state_radius * scale, 0.5, 2.0);
}

class SvgCanvas : public Canvas {
 public:
  SvgCanvas(int width, int height, const std::string& title) {
    out_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n<title>{2}</title>\n<defs>\n",
        width, height, html_escaped(title));
    // Hatching repeats the meaning of the colour: diagonal lines for gap, horizontal ones for sparse. Only
    // states are drawn as dots.
    out_ += fmt::format(
        "<pattern id=\"sparse\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\"><rect width=\"8\" "
        "height=\"8\" fill=\"{0}\"/>"
        "<path d=\"M0 4H8\" stroke=\"#1b1b1b\" stroke-opacity=\"0.35\" stroke-width=\"0.7\"/></pattern>\n"
        "<pattern id=\"gap\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\"><rect width=\"7\" "
        "height=\"7\" fill=\"{1}\"/>"
        "<path d=\"M-1 8L8 -1M-1 1L1 -1M6 8L8 6\" stroke=\"#1b1b1b\" stroke-opacity=\"0.55\" "
        "stroke-width=\"0.9\"/></pattern>\n</defs>\n",
        colour(Label::sparse), colour(Label::gap));
    out_ += fmt::format(
        "<style>.safe{{fill:{}}}.sparse{{fill:url(#sparse)}}.gap{{fill:url(#gap)}}.blank{{fill:{}}}"
        ".state{{stroke:#000;stroke-linecap:round;fill:none;stroke-opacity:.75}}.body{{stroke:{};stroke-"
        "width:1.4;fill:none}}"
        ".frame{{fill:none;stroke:#444;stroke-width:.8}}</style>\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"#fff\"/>\n",
        colour(Label::safe), colour(Label::blank), ink("outline"));
  }
  void slice(const Slice& slice, double left, double top, double scale) override {
    const LabelImage& image = slice.labels;
    const double width = image.columns * scale, height = image.rows * scale;
    // Crisp edges: a browser would leave white hairlines between the boxes.
    out_ += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">\n<g shape-rendering=\"crispEdges\">\n",
                        left, top);
    for (const LabelBox& box : label_boxes(image))
      out_ +=
          fmt::format("<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n",
                      name(box.label), box.left * scale, (image.rows - box.above) * scale,
                      (box.right - box.left) * scale, (box.above - box.below) * scale);
    out_ += fmt::format("</g>\n<svg width=\"{0:.1f}\" height=\"{1:.1f}\" viewBox=\"0 0 {0:.1f} {1:.1f}\">\n",
                        width, height);
    if (!slice.states.empty()) {
      out_ += fmt::format("<path class=\"state\" stroke-width=\"{:.2f}\" d=\"", 2 * radius_of(slice, scale));
      for (const auto& s : slice.states)
        out_ += fmt::format("M{:.1f} {:.1f}h0", s.x() * scale, height - s.y() * scale);
      out_ += "\"/>\n";
    }
    if (!slice.outline.empty()) {
      out_ += "<path class=\"body\" d=\"";
      for (const auto& [from, to] : slice.outline)
        out_ += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", from.x() * scale, height - from.y() * scale,
                            to.x() * scale, height - to.y() * scale);
      out_ += "\"/>\n";
    }
    out_ += "</svg>\n</g>\n";
  }
  void swatch(Label label, double left, double top, double width, double height) override {
    rectangle(name(label), left, top, width, height);
  }
  void state(double x, double y) override {
    out_ += fmt::format("<path class=\"state\" stroke-width=\"3\" d=\"M{} {}h0\"/>\n", x, y);
  }
  void outline(double x, double y, double length) override {
    out_ += fmt::format("<path class=\"body\" d=\"M{} {}h{}\"/>\n", x, y, length);
  }
  void frame(double left, double top, double width, double height) override {
    rectangle("frame", left, top, width, height);
  }
  void text(double x, double y, Anchor anchor, const std::string& words, bool large) override {
    const char* const anchors[] = {"", " text-anchor=\"middle\"", " text-anchor=\"end\""};
    out_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}{}>{}</text>\n", x, y,
                        anchors[static_cast<std::size_t>(anchor)], large ? " font-size=\"14\"" : "",
                        html_escaped(words));
  }
  std::string bytes() const { return out_ + "</svg>\n"; }

 private:
  void rectangle(std::string_view kind, double left, double top, double width, double height) {
    out_ += fmt::format("<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                        kind, left, top, width, height);
  }
  std::string out_;
};

// The same by gnuplot, as PNG or PDF.
class PlotCanvas : public Canvas {
 public:
  PlotCanvas(int width, int height) : width_(width), height_(height) {
    for (const Label label : all_labels) {
      unsigned value = 0;
      std::sscanf(colour(label).c_str() + 1, "%x", &value);
      for (unsigned part = 0; part < 3; ++part) rgb_[label][part] = int(value >> (16 - 8 * part) & 255);
    }
  }
  void slice(const Slice& slice, double left, double top, double scale) override {
    const LabelImage& labels = slice.labels;
    const double width = labels.columns * scale, height = labels.rows * scale;
    image(left, top, width, height, [&](int x, int y) {
      const auto sample = [&](int pixel, int most) {
        return std::min(most - 1, static_cast<int>((pixel + 0.5) / scale));
      };
      return labels.at(sample(x, labels.columns), labels.rows - 1 - sample(y, labels.rows));
    });
    const auto placed = [&](const Eigen::Vector2d& p) {
      return fmt::format("{:.1f} {:.1f}\n", left + p.x() * scale, top + height - p.y() * scale);
    };
    std::string states, body;
    for (const Eigen::Vector2d& state : slice.states) states += placed(state);
    for (const auto& [from, to] : slice.outline) body += placed(from) + placed(to) + "\n";
    if (!states.empty()) dots(states, radius_of(slice, scale));
    if (!body.empty()) lines(body);
  }
  void swatch(Label label, double left, double top, double width, double height) override {
    image(left, top, width, height, [label](int, int) { return label; });
  }
  void state(double x, double y) override { dots(fmt::format("{} {}\n", x, y), 1.5); }
  void outline(double x, double y, double length) override {
    lines(fmt::format("{0} {2}\n{1} {2}\n", x, x + length, y));
  }
  void frame(double left, double top, double width, double height) override {
    decorations_ += fmt::format(
        "set object rectangle from {:.1f},{:.1f} to {:.1f},{:.1f} front fs empty border lc rgb "
        "'#444444' lw 0.8\n",
        left, top, left + width, top + height);
  }
  void text(double x, double y, Anchor anchor, const std::string& words, bool large) override {
    const char* const anchors[] = {"left", "center", "right"};
    decorations_ +=
        fmt::format("set label '{}' at {:.1f},{:.1f} {} noenhanced font 'sans,{}' front\n", plain_text(words),
                    x, y - 4, anchors[static_cast<std::size_t>(anchor)], large ? 10 : 9);
  }
  std::optional<std::string> bytes(bool pdf) const {
    const std::string script =
        data_ + decorations_ +
        fmt::format(
            "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at "
            "screen "
            "1\nunset border\nunset tics\nunset key\nset xrange [0:{}]\nset yrange [{}:0]\n",
            width_, height_) +
        plots_ + "\n";
    return pdf ? draw_pdf(width_, height_, script) : draw_png(width_, height_, script);
  }

 private:
  // Pixels of a rectangle, hatched as in the SVG: #1b1b1b laid over the label's colour. label_at(x, y): from its top
  // left corner.
  template <class LabelAt>
  void image(double left, double top, double width, double height, LabelAt label_at) {
    std::string pixels;
    for (int y = 0; y < std::max(1, static_cast<int>(std::lround(height))); ++y)
      for (int x = 0; x < std::max(1, static_cast<int>(std::lround(width))); ++x) {
        const Label label = label_at(x, y);
        const double dark = label == Label::gap && (x + y) % 7 == 0 ? 0.5
                            : label == Label::sparse && y % 8 == 4  ? 0.25
                                                                    : 0.0;
        pixels += fmt::format("{:.1f} {:.1f}", left + x + 0.5, top + y + 0.5);
        for (const int part : rgb_[label])
          pixels += fmt::format(" {}", std::lround((1 - dark) * part + dark * 0x1b));
        pixels += '\n';
      }
    plot(pixels, "using 1:2:3:4:5 with rgbimage");
  }
  void dots(const std::string& at, double radius) {
    plot(at, fmt::format("using 1:2:({:.2f}) with circles fs solid noborder lc rgb '#202020'", radius));
  }
  void lines(const std::string& through) {
    plot(through, fmt::format("with lines lw 1.4 lc rgb '{}'", ink("outline")));
  }
  void plot(const std::string& lines, const std::string& style) {
    const std::string block = fmt::format("part{}", parts_++);
    data_ += data_block(block, lines);
    plots_ += (plots_.empty() ? "plot $" : ", $") + block + " " + style;
  }

  int width_, height_, parts_ = 0;
  ByLabel<std::array<int, 3>> rgb_;
  std::string data_, plots_, decorations_;
};

// Room left of each slice for the numbers of its upward axis, below one another with the axis' name.
int margin_of(const CoveragePicture& picture) {
  std::size_t longest = 5;
  for (const int axis : {1, 2})
    for (const double end : {picture.box.low[axis], picture.box.high[axis]})
      longest = std::max(longest, fmt::formatted_size("{:.4g}", Units(picture.spacing).length(end)));
  return 54 + 8 * static_cast<int>(longest - 5);
}

void draw_slice(const CoveragePicture& picture, const Slice& slice, double left, double below,
                Canvas& canvas) {
  const double scale = panel / static_cast<double>(std::max(slice.labels.columns, slice.labels.rows));
  const double width = slice.labels.columns * scale, height = slice.labels.rows * scale,
               top = below + panel - height;
  // A panel too flat for the name of its upward axis between two numbers has it in the caption.
  const bool flat = height < 46;
  const std::string across = axis_name[static_cast<std::size_t>(slice.normal)],
                    right = axis_name[static_cast<std::size_t>(slice.u)],
                    up = axis_name[static_cast<std::size_t>(slice.v)];
  const Units units(picture.spacing);
  const auto number = [&](double metres) { return fmt::format("{:.4g}", units.length(metres)); };
  canvas.text(
      left, top - 8, Anchor::left,
      across + " = " + units.distance(picture.through[slice.normal]) + (flat ? ", " + up + " \u2191" : ""));
  canvas.slice(slice, left, top, scale);
  canvas.frame(left, top, width, height);
  canvas.text(left, top + height + 16, Anchor::left, number(picture.box.low[slice.u]));
  canvas.text(left + width, top + height + 16, Anchor::right,
              number(picture.box.high[slice.u]) + " " + units.of_length());
  canvas.text(left + width / 2, top + height + 16, Anchor::middle, right + " \u2192");
  canvas.text(left - 6, top + height, Anchor::right, number(picture.box.low[slice.v]));
  canvas.text(left - 6, top + 10, Anchor::right, number(picture.box.high[slice.v]));
  if (!flat) canvas.text(left - 6, top + height / 2, Anchor::right, up + " \u2191");
}

void draw_legend(const CoveragePicture& picture, int margin, bool too_many, Canvas& canvas) {
  const double top = title_height + panel + 54, right = margin + panel + margin;
  const Units units(picture.spacing);
  double all = 0;
  for (const double v : picture.volume.values) all += v;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto label = static_cast<Label>(i);
    const double y = top + 22 * static_cast<double>(i);
    canvas.swatch(label, margin, y, 26, 15);
    canvas.frame(margin, y, 26, 15);
    canvas.text(
        margin + 34, y + 12, Anchor::left,
        fmt::format("{}: {:.4g} {}\u00b3, {:.1f} %, {} component{}", name(label),
                    units.volume(picture.volume[i]), units.of_length() == std::string_view("m") ? "m" : "cm",
                    all > 0 ? 100 * picture.volume[i] / all : 0.0, picture.components[i],
                    picture.components[i] == 1 ? "" : "s"));
  }
  canvas.state(right + 13, top + 8);
  canvas.text(
      right + 34, top + 12, Anchor::left,
      fmt::format("{} states{}", picture.states.size(),
                  too_many ? " (too many near a slice to draw)" : ", those within h/2 of a slice drawn"));
  if (picture.body.empty()) return;
  canvas.outline(right, top + 30, 26);
  canvas.text(right + 34, top + 34, Anchor::left, "body at rest");
}

void draw(const CoveragePicture& picture, int margin, Canvas& canvas) {
  canvas.text(margin, 20, Anchor::left, picture.title, true);
  bool too_many = false;
  for (int i = 0; i < 3; ++i) {
    const Slice slice = cut(picture, 2 - i);
    too_many = too_many || slice.too_many_states;
    draw_slice(picture, slice, margin + i * (panel + margin), title_height + 10, canvas);
  }
  draw_legend(picture, margin, too_many, canvas);
}

std::string drawn_by_gnuplot(const std::filesystem::path& file, const CoveragePicture& picture, int margin,
                             PlotCanvas canvas) {
  if (!have_gnuplot())
    throw InputError({.file = file.string()}, "a PNG or PDF needs gnuplot, which is missing; expected .svg");
  check_writable(file);
  draw(picture, margin, canvas);
  const std::optional<std::string> bytes = canvas.bytes(file.extension() == ".pdf");
  if (!bytes)
    throw InputError({.file = file.string()}, "gnuplot could not draw it, expected one with cairo, or .svg");
  return *bytes;
}

}  // namespace

void write_coverage_picture(const std::filesystem::path& file, const CoveragePicture& picture) {
  const int margin = margin_of(picture), width = 3 * panel + 4 * margin;
  const int height = title_height + panel + 34 + legend_height;
  if (file.extension() != ".svg")
    return write_whole(file, drawn_by_gnuplot(file, picture, margin, PlotCanvas(width, height)));
  SvgCanvas canvas(width, height, picture.title);
  draw(picture, margin, canvas);
  write_whole(file, canvas.bytes());
}

}  // namespace forefeel
