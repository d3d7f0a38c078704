#include "apps/picture/report_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/picture/plot.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr std::array labels{Label::safe, Label::sparse, Label::gap, Label::blank};

using Frames = std::span<const FrameRecord>;

template <class Value>
std::vector<double> values_of(Frames frames, Value value) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameRecord& frame : frames) values.push_back(value(frame));
  return values;
}
std::vector<double> values_of(Frames frames, double Judgement::*member) {
  return values_of(frames, [member](const FrameRecord& f) { return f.judged.*member; });
}
std::vector<double> values_of(Frames frames, double FrameTiming::*member) {
  return values_of(frames, [member](const FrameRecord& f) { return f.timing.*member; });
}
template <class Force>
std::vector<double> norms(Frames frames, Force force) {
  return values_of(frames, [force](const FrameRecord& f) {
    const Vec3& v = force(f);
    return std::hypot(v[0], v[1], v[2]);
  });
}

std::string scatter(const std::vector<double>& x, const std::vector<double>& y) {
  std::string lines;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(y[i])) lines += fmt::format("{:.6g} {:.6g}\n", x[i], y[i]);
  return lines;
}

double largest(const std::vector<double>& values, double at_least) {
  double most = at_least;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, value);
  return most;
}

// Runs of one label as boxes "x_low x_high" per label.
std::string strip_blocks(Frames frames, const std::vector<double>& t) {
  std::array<std::string, labels.size()> boxes;
  for (std::size_t begin = 0, end = 0; begin < t.size(); begin = end) {
    const Label label = frames[begin].label;
    while (end < t.size() && frames[end].label == label) ++end;
    const double until = end < t.size() ? t[end] : t.back();
    for (std::size_t i = 0; i < labels.size(); ++i)
      if (label == labels[i])
        boxes[i] += fmt::format("{:.6g} 0.5 {:.6g} {:.6g} 0 1\n", 0.5 * (t[begin] + until), t[begin], until);
  }
  std::string blocks;
  for (std::size_t i = 0; i < labels.size(); ++i)
    blocks += data_block(fmt::format("strip_{}", name(labels[i])), boxes[i]);
  return blocks;
}

const char* const common_style = R"(
set border 3 lc rgb '#8a8a8a' lw 0.8
set tics nomirror out scale 0.5 textcolor rgb '#3a3a3a'
set grid ytics lc rgb '#e4e1da' lw 0.7
)";

// Forces over time, as data blocks and as one plot.
struct Curves {
  std::vector<double> t, rendered, undamped, reference;
  double end = 1e-3;  // [s]

  explicit Curves(Frames frames)
      : t(values_of(frames, [](const FrameRecord& f) { return f.t; })),
        rendered(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.sent; })),
        undamped(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.undamped; })),
        reference(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.judged.reference; })) {
    if (t.size() > 1) end = t.back() + t[1] - t[0];
  }
  std::pair<std::size_t, std::size_t> rows(double from, double until) const {
    return {static_cast<std::size_t>(std::ranges::lower_bound(t, from) - t.begin()),
            static_cast<std::size_t>(std::ranges::upper_bound(t, until) - t.begin())};
  }
  std::string blocks(double from, double until, std::size_t bins) const {
    const auto [begin, last] = rows(from, until);
    const auto part = [&, first = begin, n = last - begin](const std::vector<double>& values) {
      return std::span(values).subspan(first, n);
    };
    return data_block("rendered", thinned_curve(part(t), part(rendered), bins)) +
           data_block("undamped", thinned_curve(part(t), part(undamped), bins)) +
           data_block("reference", scatter(t, reference));
  }
  std::string plot(double from, double until) const {
    const auto [begin, last] = rows(from, until);
    double top = 0.1;
    for (std::size_t i = begin; i < last; ++i) top = std::max(top, rendered[i]);
    return fmt::format(
        "set key top right horizontal samplen 2 textcolor rgb '#3a3a3a'\nset yrange [0:{:.4g}]\nset "
        "ylabel 'force, N' offset 1\n"
        "plot $reference with points pt 7 ps 0.55 lc rgb '{}' title 'reference', $undamped with lines lw 1 "
        "lc rgb '{}' title 'newest model, undamped', "
        "$rendered with lines lw 1.3 lc rgb '{}' title 'rendered'\n",
        1.2 * top, ink::reference_light, ink::undamped, ink::rendered);
  }
};

std::string screen_part(double top, double bottom) {
  return fmt::format("set tmargin at screen {}\nset bmargin at screen {}\n", top, bottom);
}

std::string strip_plot() {
  std::string text;
  for (const Label label : labels)
    text +=
        fmt::format("{}$strip_{} using 1:2:3:4:5:6 with boxxyerror fs solid 1 noborder fc rgb '{}' notitle",
                    text.empty() ? "plot " : ", ", name(label), colour(label));
  return text + "\n";
}

std::string error_plot() {
  return fmt::format(
      "set key top right horizontal samplen 2 textcolor rgb '#3a3a3a'\nset logscale y\nset format y "
      "'10^{{%T}}'\n"
      "set yrange [1e-6:3]\nset ylabel 'relative error' offset 1\nset arrow from graph 0, first 0.07 to "
      "graph 1, first 0.07 nohead lw 0.8 dt 2 lc rgb '#6a6a6a' back\n"
      "set label '7 %' at graph 0.97, first 0.12 textcolor rgb '#6a6a6a'\n"
      "plot $error with lines lw 1 lc rgb '{}' title 'rendered', $approximation with points pt 7 ps 0.3 lc "
      "rgb '{}' title 'approximation', "
      "$staleness with points pt 7 ps 0.3 lc rgb '{}' title 'staleness', $switch with points pt 7 ps 0.3 lc "
      "rgb '{}' title 'switch'\n",
      ink::rendered, ink::approximation, ink::staleness, ink::switching);
}

// The round number (1, 2 or 5 times a power of ten) at or above a value.
double round_step(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (value <= factor * power) return factor * power;
  return 10 * power;
}

// ---- slices
// -------------------------------------------------------------------------------------------------------

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

// Labels on a grid of the plane, as boxes in mm: rows of equal label first, equal rows merged upwards.
struct LabelBoxes {
  std::array<std::string, labels.size()> lines;

  LabelBoxes(const StateSpace& space, const Plane& plane, const Window& window, int columns) {
    const double step = (window.right - window.left) / columns;
    const int rows = std::max(1, static_cast<int>(std::ceil((window.top - window.bottom) / step)));
    struct Strip {
      int begin, end, row;
      Label label;
    };
    std::vector<Strip> open;
    PathWalk walk;
    const auto close = [&](const Strip& strip, int row) {
      const double left = window.left + strip.begin * step, right = window.left + strip.end * step;
      const double low = window.bottom + strip.row * step, high = window.bottom + row * step;
      lines[static_cast<std::size_t>(strip.label)] +=
          fmt::format("{:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g}\n", 500 * (left + right), 500 * (low + high),
                      1e3 * left, 1e3 * right, 1e3 * low, 1e3 * high);
    };
    for (int row = 0; row <= rows; ++row) {
      std::vector<Strip> here;
      for (int i = 0; i < columns && row < rows; ++i) {
        Vec3 q = Vec3::Constant(plane.level);
        q[plane.across] = window.left + (i + 0.5) * step;
        q[plane.up] = window.bottom + (row + 0.5) * step;
        const Label label = space.label(q, walk);
        if (here.empty() || here.back().label != label) here.push_back({i, i, row, label});
        here.back().end = i + 1;
      }
      for (const Strip& strip : open) {
        const auto same = std::ranges::find_if(here, [&](const Strip& s) {
          return s.begin == strip.begin && s.end == strip.end && s.label == strip.label;
        });
        if (same == here.end())
          close(strip, row);
        else
          same->row = strip.row;
      }
      open = std::move(here);
    }
  }
};

// The states known so far, and where they are drawn [mm].
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

std::string panel(const SliceInput& slice, KnownStates& known, const Plane& plane, const Window& window,
                  double until, int number) {
  const auto& [path, t, states] = slice;
  known.grow(slice, plane, until);
  const LabelBoxes boxes(known.space, plane, window, 110);
  std::string script;
  for (const Label label : labels)
    script += data_block(fmt::format("slice{}_{}", number, name(label)),
                         boxes.lines[static_cast<std::size_t>(label)]);
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
  for (const Label label : labels)
    script +=
        fmt::format("$slice{}_{} using 1:2:3:4:5:6 with boxxyerror fs solid 1 noborder fc rgb '{}' notitle, ",
                    number, name(label), colour(label));
  return script + fmt::format(
                      "$elsewhere{0} with points pt 7 ps 0.2 lc rgb '#9a9a9a' notitle, "
                      "$in_plane{0} with points pt 7 ps 0.45 lc rgb '#ffffff' notitle, "
                      "$in_plane{0} with points pt 6 ps 0.45 lw 0.7 lc rgb '#1b1b1b' notitle, "
                      "$trail{0} with lines lw 1.3 lc rgb '#c2185b' notitle\n",
                      number);
}

// ---- deadlines
// ----------------------------------------------------------------------------------------------------

// Counts in equal steps of log10, with a floor of one tenth of a microsecond.
std::string histogram(const std::vector<double>& values, double& peak) {
  constexpr int per_decade = 12, bins = 6 * per_decade;
  std::array<std::size_t, bins> counts{};
  for (const double value : values)
    if (std::isfinite(value))
      ++counts[static_cast<std::size_t>(std::clamp(
          static_cast<int>(std::floor((std::log10(std::max(value, 0.1)) + 1) * per_decade)), 0, bins - 1))];
  std::string lines;
  for (int i = 0; i < bins; ++i) {
    if (counts[static_cast<std::size_t>(i)] == 0) continue;
    const double low = std::pow(10, static_cast<double>(i) / per_decade - 1),
                 high = std::pow(10, (i + 1.0) / per_decade - 1);
    const auto count = static_cast<double>(counts[static_cast<std::size_t>(i)]);
    peak = std::max(peak, count);
    lines += fmt::format("{:.5g} {} {:.5g} {:.5g} 0.5 {}\n", std::sqrt(low * high), count, low, high, count);
  }
  return lines;
}

}  // namespace

Figure time_figure(Frames frames) {
  const Curves curves(frames);
  const std::vector<double> states =
      values_of(frames, [](const FrameRecord& f) { return static_cast<double>(f.known); });
  std::string script = curves.blocks(0, curves.end, 1400) + common_style + strip_blocks(frames, curves.t) +
                       data_block("known", thinned_curve(curves.t, states, 700));
  const std::pair<const char*, double Judgement::*> parts[] = {{"error", &Judgement::error},
                                                               {"approximation", &Judgement::approximation},
                                                               {"switch", &Judgement::switching},
                                                               {"staleness", &Judgement::staleness}};
  for (const auto& [part, member] : parts)
    script += data_block(part, scatter(curves.t, values_of(frames, member)));
  script += fmt::format(
      "set multiplot\nset xrange [0:{}]\nset lmargin at screen 0.075\nset rmargin at screen 0.985\n"
      "set format x ''\n",
      curves.end);
  script += screen_part(0.985, 0.60) + curves.plot(0, curves.end);
  script +=
      screen_part(0.585, 0.555) +
      "unset ylabel\nset yrange [0:1]\nunset ytics\nunset grid\nset border 0\nunset xtics\nunset key\n" +
      strip_plot();
  script += "set border 3\nset xtics nomirror out scale 0.5\nset ytics nomirror autofreq\nset grid ytics\n";
  const double known = largest(states, 1);
  script +=
      screen_part(0.535, 0.385) + fmt::format(
                                      "set yrange [0:{}]\nset ytics {}\nset ylabel 'states known' offset 1\n"
                                      "plot $known with lines lw 1.6 lc rgb '{}' notitle\n",
                                      1.1 * known, round_step(known / 4), ink::rendered);
  script += screen_part(0.365, 0.065) +
            "set format x '%g'\nset ytics autofreq\nset xlabel 'time, s' offset 0,0.6\n" + error_plot();
  return {"time",
          "Force of the body on the hand, the label where the hand is, how many states are known, and the "
          "error of the rendered force with "
          "its three parts where they are above 1e-6. Reference: tight solves on the reference branch, "
          "sampled along the path.",
          960, 820, script + "unset multiplot\n"};
}

Figure start_figure(Frames frames) {
  const Curves curves(frames);
  const double end = std::min(curves.end, 0.6);
  return {"start",
          "The first moments, when next to nothing is known: the first models fade in, and each new model is "
          "taken in "
          "steps below what a hand can tell.",
          960, 290,
          curves.blocks(0, end, 1500) + common_style +
              fmt::format("set xrange [0:{}]\nset lmargin at screen 0.075\nset rmargin at screen 0.985\n"
                          "set xlabel 'time, s' offset 0,0.5\n",
                          end) +
              curves.plot(0, end)};
}

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
      common_style +
      fmt::format(
          "unset grid\nset multiplot layout 1,3 margins 0.065,0.99,{:.4f},{:.4f} spacing 0.045,0.1\nset size "
          "ratio -1\nset xrange [{:.5g}:{:.5g}]\nset yrange [{:.5g}:{:.5g}]\n"
          "set xlabel '{}, mm' offset 0,0.5\nset object 1 rectangle from {:.5g},{:.5g} to {:.5g},{:.5g} fs "
          "empty border rgb '#1b1b1b' dt 3 front\n",
          62.0 / height, 1 - 44.0 / height, 1e3 * left, 1e3 * right, 1e3 * bottom, 1e3 * top,
          axes[plane.across], 1e3 * space.box.low[plane.across], 1e3 * space.box.low[plane.up],
          1e3 * space.box.high[plane.across], 1e3 * space.box.high[plane.up]) +
      fmt::format("set ylabel '{}, mm' offset 1\n", axes[plane.up]);
  int number = 0;
  KnownStates known{StateSpace(space), {}, {}};
  for (const double share : {0.125, 0.5, 1.0}) {
    script += panel(slice, known, plane, window, share * end, ++number);
    script += "unset ylabel\n";
  }
  return {"slice",
          fmt::format("Labels in the plane {} = {:.3g} mm, states (circles: within half a spacing of the "
                      "plane; grey: elsewhere), "
                      "path of the hand so far, and the box (dotted).",
                      axes[plane.through], 1e3 * plane.level),
          960, height, script + "unset multiplot\n"};
}

bool has_deadlines(Frames frames) {
  return std::ranges::any_of(frames, [](const FrameRecord& f) { return std::isfinite(f.timing.cost_us); });
}

Figure deadline_figure(Frames frames) {
  double peak = 1;
  const std::string cost = histogram(values_of(frames, &FrameTiming::cost_us), peak),
                    late = histogram(values_of(frames, &FrameTiming::lateness_us), peak);
  const std::string script =
      data_block("cost", cost) + data_block("late", late) + common_style +
      fmt::format(
          "set multiplot layout 1,2 margins 0.075,0.985,0.2,0.88 spacing 0.07,0.1\nset logscale xy\nset "
          "xrange [0.1:1e5]\nset yrange [0.5:{}]\n"
          "set format x '10^{{%T}}'\nset format y '10^{{%T}}'\nset ylabel 'frames'\nset arrow from first "
          "1000, graph 0 to first 1000, graph 1 nohead lw 0.8 dt 2 lc rgb '#6a6a6a'\n"
          "set label 'one frame' at first 1150, graph 0.93 textcolor rgb '#6a6a6a'\n",
          2 * peak) +
      fmt::format(
          "set title 'cost of a frame'\nset xlabel 'microseconds'\nplot $cost using 1:2:3:4:5:6 with "
          "boxxyerror fs solid 1 noborder fc rgb '{}' notitle\n"
          "unset ylabel\nset title 'lateness of the wake-up'\nplot $late using 1:2:3:4:5:6 with boxxyerror "
          "fs solid 1 noborder fc rgb '{}' notitle\nunset multiplot\n",
          ink::reference, ink::switching);
  return {"deadline",
          "Loop at 1 kHz: what a frame costs and how late the system wakes the loop are different things; "
          "both axes logarithmic.",
          960, 290, script};
}

}  // namespace forefeel
