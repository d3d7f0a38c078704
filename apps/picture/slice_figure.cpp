#include "apps/picture/slice_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/picture/label_image.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/index/path_walk.hpp"

namespace forefeel {
namespace {

struct Plane {
  int across = 0, up = 2, through = 1;  // axes
  double level = 0;                     // of the slice [m]
};

Plane plane_of_most_motion(const std::array<std::vector<double>, 3>& path) {
  std::array<double, 3> extent{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!path[axis].empty()) extent[axis] = std::ranges::max(path[axis]) - std::ranges::min(path[axis]);
  const auto through = static_cast<int>(std::ranges::min_element(extent) - extent.begin());
  std::vector<double> level = path[static_cast<std::size_t>(through)];
  Plane plane{through == 0 ? 1 : 0, through == 2 ? 1 : 2, through, 0};
  if (level.empty()) return plane;
  plane.level = median(std::move(level));
  return plane;
}

struct Window {
  double left, right, bottom, top;  // [m]
};

// Labels in the plane as boxes in mm, one text for each label.
ByLabel<std::string> label_lines(const StateSpace& space, const Plane& plane, const Window& window,
                                 int columns) {
  const double step = (window.right - window.left) / columns;
  const int rows = std::max(1, static_cast<int>(std::ceil((window.top - window.bottom) / step)));
  PathWalk walk;
  const LabelImage image(columns, rows, [&](int column, int row) {
    Vec3 q = Vec3::Constant(plane.level);
    q[plane.across] = window.left + (column + 0.5) * step;
    q[plane.up] = window.bottom + (row + 0.5) * step;
    return space.label(q, walk);
  });
  ByLabel<std::string> lines;
  for (const LabelBox& box : label_boxes(image)) {
    const double left = window.left + box.left * step, right = window.left + box.right * step;
    const double low = window.bottom + box.below * step, high = window.bottom + box.above * step;
    lines[box.label] += fmt::format("{:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g}\n", 500 * (left + right),
                                    500 * (low + high), 1e3 * left, 1e3 * right, 1e3 * low, 1e3 * high);
  }
  return lines;
}

// The states known so far, and their places in the drawing [mm].
struct KnownStates {
  StateSpace space;
  std::string in_plane, elsewhere;
  std::size_t taken = 0;  // of the slice's

  void grow(const SliceInput& slice, const Plane& plane, double until) {
    for (; taken < slice.states.size() && slice.states[taken].first <= until; ++taken) {
      const State& state = slice.states[taken].second;
      if (!space.insert(state).is_new) continue;
      const bool near = std::abs(state.at[plane.through] - plane.level) <= 0.5 * space.options().spacing;
      (near ? in_plane : elsewhere) +=
          fmt::format("{:.5g} {:.5g}\n", 1e3 * state.at[plane.across], 1e3 * state.at[plane.up]);
    }
  }
};

std::string panel_at(const SliceInput& slice, KnownStates& known, const Plane& plane, const Window& window,
                     double until, int number) {
  const auto& [path, t, states] = slice;
  known.grow(slice, plane, until);
  const auto boxes = label_lines(known.space, plane, window, 110);
  std::string script;
  for (const Label label : all_labels)
    script += data_block(fmt::format("slice{}_{}", number, name(label)), boxes[label]);
  script += data_block(fmt::format("in_plane{}", number), known.in_plane) +
            data_block(fmt::format("elsewhere{}", number), known.elsewhere);
  const auto past = static_cast<std::size_t>(std::ranges::upper_bound(t, until) - t.begin());
  std::string trail;
  const std::size_t stride = std::max<std::size_t>(1, t.size() / 1500);
  for (std::size_t i = 0; i < past; i += stride)
    trail += fmt::format("{:.5g} {:.5g}\n", 1e3 * path[static_cast<std::size_t>(plane.across)][i],
                         1e3 * path[static_cast<std::size_t>(plane.up)][i]);
  script += data_block(fmt::format("trail{}", number), trail);
  script += fmt::format("set title 'after {:.3g} s, {} states' textcolor rgb '#3a3a3a'\nplot ", until,
                        known.space.size());
  for (const Label label : all_labels)
    script +=
        fmt::format("$slice{}_{} using 1:2:3:4:5:6 with boxxyerror fs solid 1 noborder fc rgb '{}' notitle, ",
                    number, name(label), colour(label));
  return script + fmt::format(
                      "$elsewhere{0} with points pt 7 ps 0.2 lc rgb '#9a9a9a' notitle, "
                      "$in_plane{0} with points pt 7 ps 0.45 lc rgb '#ffffff' notitle, "
                      "$in_plane{0} with points pt 6 ps 0.45 lw 0.7 lc rgb '#1b1b1b' notitle, "
                      "$trail{0} with lines lw 1.3 lc rgb '{1}' notitle\n",
                      number, ink("path"));
}

}  // namespace

Figure slice_figure(const SliceInput& slice, const StateSpaceOptions& space) {
  const auto& [path, t, states] = slice;
  const Plane plane = plane_of_most_motion(path);
  const auto range = [&](int axis) {
    const std::vector<double>& values = slice.path[static_cast<std::size_t>(axis)];
    const double margin = 0.5 * space.spacing;
    const double low = values.empty() ? 0 : std::ranges::min(values),
                 high = values.empty() ? 0 : std::ranges::max(values);
    return std::pair(std::min(space.box.low[axis], low) - margin,
                     std::max(space.box.high[axis], high) + margin);
  };
  const auto [left, right] = range(plane.across);
  const auto [bottom, top] = range(plane.up);
  const Window window{left, right, bottom, top};
  const double end = t.empty() ? 0 : t.back();
  const char* const axes[] = {"x", "y", "z"};
  const int height = static_cast<int>(std::clamp(267 * (top - bottom) / (right - left), 90.0, 700.0)) + 106;
  std::string script =
      plot_style +
      fmt::format(
          "unset grid\nset multiplot layout 1,3 margins 0.065,0.99,{:.4f},{:.4f} spacing 0.045,0.1\nset size "
          "ratio -1\nset xrange [{:.5g}:{:.5g}]\nset yrange [{:.5g}:{:.5g}]\n"
          "set xlabel '{} [mm]' offset 0,0.5\nset object 1 rectangle from {:.5g},{:.5g} to {:.5g},{:.5g} fs "
          "empty border rgb '#1b1b1b' dt 3 front\n",
          62.0 / height, 1 - 44.0 / height, 1e3 * left, 1e3 * right, 1e3 * bottom, 1e3 * top,
          axes[plane.across], 1e3 * space.box.low[plane.across], 1e3 * space.box.low[plane.up],
          1e3 * space.box.high[plane.across], 1e3 * space.box.high[plane.up]) +
      fmt::format("set ylabel '{} [mm]' offset 1\n", axes[plane.up]);
  int number = 0;
  KnownStates known{StateSpace(space), {}, {}};
  for (const double share : {0.125, 0.5, 1.0}) {
    script += panel_at(slice, known, plane, window, share * end, ++number);
    script += "unset ylabel\n";
  }
  return {"slice",
          fmt::format("Labels in the plane {} = {:.3g} mm, states (circles: within half a spacing of the "
                      "plane; grey: elsewhere), "
                      "path of the hand so far, and the box (dotted).",
                      axes[plane.through], 1e3 * plane.level),
          960, height, script + "unset multiplot\n"};
}

}  // namespace forefeel
