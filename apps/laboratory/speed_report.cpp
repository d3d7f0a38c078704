#include "apps/laboratory/speed_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* bound_row = "bound: exact force once rest can be known, the first guess before";
constexpr const char* bound_row_without = "bound: exact force once rest can be known, nothing before";
constexpr double wanted = 10;  // factor over the predecessor's speed that we want to reach
constexpr double cap = 2.0;    // highest speed tried [m/s]

std::string shown(double speed) {  // [mm/s]
  return speed > 0 ? fmt::format("{:.3g}", 1e3 * speed) : "below 15.6";
}
std::string ratio(double a, double b) {
  return a > 0 && b > 0 ? fmt::format("×{:.3g}", a / b) : "–";
}

// The predecessor on its best lattice, with its own start or with ours.
double best_predecessor(const SpeedFindings& found, std::size_t w) {
  return std::max(found.speed(SpeedRole::predecessor, w), found.speed(SpeedRole::predecessor_start, w));
}

// ---- the document

// Our method against the others with the same start.
Json start_json(const SpeedFindings& found, std::size_t w) {
  const double ours = found.speed(SpeedRole::ours, w), predecessor = best_predecessor(found, w);
  const double paper = found.speed(SpeedRole::seed_paper_start, w);
  const double best = std::max(paper, found.speed(SpeedRole::seed_paper_best_start, w));
  const auto to = [&](double other) { return number(other > 0 ? ours / other : unknown); };
  return {{"predecessor", predecessor}, {"seed_paper", paper},
          {"seed_paper_best", best},    {"to_predecessor", to(predecessor)},
          {"to_seed_paper", to(paper)}, {"to_seed_paper_best", to(best)}};
}

Json row_json(const SpeedFindings& found, std::size_t w) {
  const double ours = found.speed(SpeedRole::ours, w), paper = found.speed(SpeedRole::seed_paper, w);
  const double before = found.speed(SpeedRole::predecessor, w);
  const double best = std::max(paper, found.speed(SpeedRole::seed_paper_best, w));
  const auto to = [&](double other) { return number(other > 0 ? ours / other : unknown); };
  return {{"workers", found.workers[w]},
          {"speed", ours},
          {"predecessor", before},
          {"seed_paper", paper},
          {"to_predecessor", to(before)},
          {"to_seed_paper", to(paper)},
          {"to_seed_paper_best", to(best)},
          {"capped", ours >= cap},
          {"our_start_for_all", start_json(found, w)},
          {"rest_known_before", found.speed(SpeedRole::rest_known, w)},
          {"ten_times_in_reach", wanted * before <= std::min(cap, found.bounds.guessed)}};
}

Json summary_of(const SpeedFindings& found) {
  Json rows = Json::array();
  for (std::size_t w = 0; w < found.workers.size(); ++w) rows.push_back(row_json(found, w));
  const SpeedBounds& bounds = found.bounds;
  const Json bound{{"speed", bounds.guessed},
                   {"known", bounds.known},
                   {"settled_after", number(bounds.settled)},
                   {"speed_without_guess", bounds.without},
                   {"settled_after_without_guess", number(bounds.settled_without)}};
  return {{"travel", found.travel}, {"seeds", found.seeds}, {"rows", rows}, {"bound", bound}};
}

// ---- texts

// Whether any schedule could reach ten times the predecessor's speed.
std::string out_of_reach(double before, const SpeedBounds& bounds) {
  const double goal = wanted * before;
  if (goal > cap) return fmt::format("{} is above the highest speed tried, {}", shown(goal), shown(cap));
  if (goal > bounds.guessed)
    return fmt::format("{} is above the {} that exact models sustain", shown(goal), shown(bounds.guessed));
  return fmt::format("{} is within the {} that exact models sustain", shown(goal), shown(bounds.guessed));
}

std::string bounds_text(const SpeedFindings& found) {
  const SpeedBounds& bounds = found.bounds;
  std::string text = fmt::format(
      "The last two rows are bounds. They know the exact force everywhere as soon as rest can be solved, at "
      "{:.3f} s. They lose only the time before that and the fade-out after it: {:.3f} s from the first "
      "guess, {:.3f} s from zero force. The fade-out depends on the force and on the rule of the switch, not "
      "on policy, prediction, placement or number of workers. These rows sustain {} and {} mm/s. Ten times "
      "the predecessor's speed: ",
      bounds.known, bounds.settled, bounds.settled_without, shown(bounds.guessed), shown(bounds.without));
  double best = 0;
  for (std::size_t w = 0; w < found.workers.size(); ++w) {
    text += fmt::format("{}with {} workers {}", w > 0 ? "; " : "", found.workers[w],
                        out_of_reach(found.speed(SpeedRole::predecessor, w), bounds));
    best = std::max(best, found.speed(SpeedRole::ours, w));
  }
  text += ". Under this switch, no scheduler with correct models can be faster than the bound. ";
  if (best > bounds.guessed)
    text += fmt::format(
        "Only a wrong model can be slightly faster: if it is nearer to the guess than the true force, less "
        "has to fade out ({} at best). ",
        shown(best));
  return text;
}

std::string comparison(const SpeedFindings& found, std::size_t w) {
  const double ours = found.speed(SpeedRole::ours, w), before = found.speed(SpeedRole::predecessor, w),
               paper = found.speed(SpeedRole::seed_paper, w);
  return fmt::format(
      "{} workers: {} mm/s; predecessor at its best {}, {}; seed paper {}, {} (on its best lattice {})",
      found.workers[w], shown(ours), shown(before), ratio(ours, before), shown(paper), ratio(ours, paper),
      ratio(ours, std::max(paper, found.speed(SpeedRole::seed_paper_best, w))));
}

std::string comparison_with_our_start(const SpeedFindings& found, std::size_t w) {
  const double ours = found.speed(SpeedRole::ours, w), before = found.speed(SpeedRole::predecessor_start, w),
               paper = found.speed(SpeedRole::seed_paper_start, w),
               paper_12 = found.speed(SpeedRole::seed_paper_best_start, w);
  return fmt::format(
      "{} workers, the others with our start too: predecessor {}, {}; seed paper {}, {} (on 12 mm {}, {}); "
      "ours with rest known before the start: {}",
      found.workers[w], shown(before), ratio(ours, before), shown(paper), ratio(ours, paper), shown(paper_12),
      ratio(ours, paper_12), shown(found.speed(SpeedRole::rest_known, w)));
}

constexpr const char* what_is_measured =
    "The highest speed at which 95 % of first visits are within 7 % of the reference. A first visit is the "
    "first frame in a cell of 6 mm. Each run starts with no states and follows lines across the box, layer "
    "by layer. Speeds up to 2 m/s are tried. In brackets: factor over the predecessor (nearest states "
    "first, polynomials on the lattice) at its best spacing and degree for that number of workers; it has "
    "no damped switch. While nothing is known there is no force, and the first model fades in from zero at "
    "the rate of the switch. A run of length L at speed v loses 5 % of its visits in 0.05 L / v, so the "
    "first solve and its fade-in must fit into this time: 0.25 m / v at L = 5 m. Our sessions begin with "
    "the state at rest. It is known to be in equilibrium, so it needs no iteration, only one factorisation "
    "for its stiffness. This is charged as one of the four iterations that a state takes on average. Until "
    "it is solved, the hand feels a guess: the body's stiffness at rest, from one factorisation before the "
    "session. The earlier rows, the predecessor and the seed paper have neither; the "
    "last rows give them the same start. If rest is known before the start, nothing fades in. The row "
    "without the switch shows the cost of the fade-in, the row before it the value of knowing the motion. "
    "With few workers the share within 7 % stays close to 95 % over a wide range of speeds, so one or two "
    "frames decide the result of a single seed: `--seeds` takes the geometric mean of several.";

// ---- table and picture

struct NamedSpeeds {
  std::string name;
  std::vector<double> speeds;  // by number of workers [m/s]
};

std::vector<NamedSpeeds> bound_rows(const SpeedFindings& found) {
  const std::size_t n = found.workers.size();
  return {{bound_row, std::vector<double>(n, found.bounds.guessed)},
          {bound_row_without, std::vector<double>(n, found.bounds.without)}};
}

std::vector<NamedSpeeds> all_rows(const SpeedFindings& found) {
  std::vector<NamedSpeeds> rows;
  for (std::size_t s = 0; s < found.speeds.size(); ++s)
    rows.push_back({speed_steps()[s].name, found.speeds[s]});
  for (NamedSpeeds& row : bound_rows(found)) rows.push_back(std::move(row));
  return rows;
}

std::string table_of(const SpeedFindings& found) {
  std::vector<std::vector<std::string>> table{{"sustained speed [mm/s]"}};
  for (const int workers : found.workers) table[0].push_back(fmt::format("{} workers", workers));
  for (const NamedSpeeds& row : all_rows(found)) {
    table.push_back({row.name});
    for (std::size_t w = 0; w < found.workers.size(); ++w)
      table.back().push_back(fmt::format("{} ({})", shown(row.speeds[w]),
                                         ratio(row.speeds[w], found.speed(SpeedRole::predecessor, w))));
  }
  return html_table(table);
}

std::vector<NamedSpeeds> curves_of(const SpeedFindings& found) {
  std::vector<NamedSpeeds> curves{{"predecessor, best lattice", {}}};
  for (std::size_t w = 0; w < found.workers.size(); ++w)
    curves[0].speeds.push_back(found.speed(SpeedRole::predecessor, w));
  for (std::size_t s = 0; s < found.speeds.size(); ++s)
    if (speed_steps()[s].drawn) curves.push_back({speed_steps()[s].name, found.speeds[s]});
  curves.push_back(bound_rows(found).front());
  return curves;
}

Figure picture_of(const SpeedFindings& found) {
  const std::vector<NamedSpeeds> curves = curves_of(found);
  std::string blocks, plot = "plot ";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    std::string lines;
    for (std::size_t w = 0; w < found.workers.size(); ++w)
      if (curves[i].speeds[w] > 0)
        lines += fmt::format("{} {}\n", found.workers[w], 1e3 * curves[i].speeds[w]);
    if (lines.empty()) lines = "1 NaN\n";
    blocks += data_block(fmt::format("curve{}", i), lines);
    plot += fmt::format("{}$curve{} using 1:2 with linespoints lw 2 pt 7 ps 0.6 lc rgb \"{}\" title \"{}\"",
                        i ? ", " : "", i, line_colour(i), curves[i].name);
  }
  return {
      .name = "speed",
      .caption = "Sustained HIP speed against workers, from an empty start.",
      .script = std::string(plot_style) + blocks +
                "set logscale xy\nset xlabel \"workers\"\nset ylabel \"sustained speed [mm/s]\"\n"
                "set xtics (2, 4, 8, 16, 32, 64)\nset xrange [1.7:75]\nset key outside right noenhanced\n" +
                plot + "\n"};
}

}  // namespace

double SpeedFindings::speed(SpeedRole role, std::size_t w) const {
  double best = 0;
  for (std::size_t s = 0; s < speeds.size(); ++s)
    if (speed_steps()[s].role == role) best = std::max(best, speeds[s][w]);
  return best;
}

void write_speed_csv(const std::filesystem::path& file, const SpeedFindings& found) {
  std::string csv = "step,workers,speed,to_predecessor,to_seed_paper\n";
  for (const NamedSpeeds& row : all_rows(found))
    for (std::size_t w = 0; w < found.workers.size(); ++w) {
      const auto over = [&](double b) {
        return b > 0 ? fmt::format("{:.4g}", row.speeds[w] / b) : std::string();
      };
      csv += fmt::format("\"{}\",{},{:.6g},{},{}\n", row.name, found.workers[w], row.speeds[w],
                         over(found.speed(SpeedRole::predecessor, w)),
                         over(found.speed(SpeedRole::seed_paper, w)));
    }
  write_whole(file, csv);
}

Findings speed_report(const SpeedFindings& found, const std::filesystem::path& folder) {
  Findings report{.summary = summary_of(found), .html = {}, .lines = {}};
  for (std::size_t w = 0; w < found.workers.size(); ++w) report.lines.push_back(comparison(found, w));
  for (std::size_t w = 0; w < found.workers.size(); ++w)
    report.lines.push_back(comparison_with_our_start(found, w));
  report.lines.push_back(bounds_text(found));
  report.html =
      paragraph("Sustained speed", what_is_measured) + table_of(found) + draw_into(folder, picture_of(found));
  for (const std::string& line : report.lines) report.html += paragraph("Found", line);
  return report;
}

}  // namespace forefeel
