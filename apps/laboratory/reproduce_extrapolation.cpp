// The paper's Fig. 2: a path of 6 cm out of the known region, in three situations. extrapolation_path.hpp
// computes the forces; this file evaluates and shows them.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"
#include "apps/laboratory/extrapolation_path.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

using namespace fig2;

nlohmann::ordered_json to_json(const Jump& jump) {
  return {{"s", number(jump.s)}, {"newton", number(jump.size)}, {"jnd", number(jump.jnd)}};
}

nlohmann::ordered_json to_json(const Curve& curve, const Judge& judge, double gap_end) {
  nlohmann::ordered_json row;
  row["setup"] = curve.setup;
  row["method"] = curve.method.name;
  row["error_complete"] = quantiles_json(errors(curve, false));
  row["error_tight"] = quantiles_json(errors(curve, true));
  row["error_tight_at_end"] = number(at_end(errors(curve, true)));
  const Largest most = largest(curve, judge);
  row["largest_jump"] = to_json(most.jnd);
  row["largest_jump_newton"] = to_json(most.newton);
  if (curve.setup == "gap") {
    const Largest inside = largest(curve, judge, 0, gap_end);
    row["in_gap"] = {{"largest_jump", to_json(inside.jnd)},
                     {"largest_jump_newton", to_json(inside.newton)},
                     {"error_tight", quantiles_json(errors(curve, true, gap_end))}};
    const auto [enters, leaves] = crossing(curve, judge);
    row["far_side_enters"] = to_json(enters);
    row["near_side_leaves"] = to_json(leaves);
  }
  return row;
}

// ---- files

std::string csv(const Fig2& fig, const Judge& judge) {
  std::string text =
      "setup,method,s,force,fx,fy,fz,label,near_side,far_side,jump,jump_jnd,error_complete,error_tight\n";
  for (const Curve& curve : fig.curves)
    for (const PathPoint& p : curve.points)
      text += fmt::format("{},\"{}\",{:.6g},{:.9g},{:.9g},{:.9g},{:.9g},{},{},{},{:.4g},{:.4g},{:.4g},{}\n",
                          curve.setup, curve.method.name, p.s, p.force.norm(), p.force[0], p.force[1],
                          p.force[2], name(p.label), p.near_side, p.far_side, p.jump,
                          judge.in_jnd(p.jump, p.force), p.error_complete,
                          std::isfinite(p.error_tight) ? fmt::format("{:.4g}", p.error_tight) : "");
  return text;
}

// One situation: the force along the path, or the error against the complete state space.
std::string panel(const Fig2& fig, const PaperStates& paper, std::size_t row, bool force, double most) {
  const std::array<const char*, 3> setups{"blank", "gap", "sparse"};
  const double top = 0.965 - 0.315 * static_cast<double>(row), bottom = top - 0.235;
  std::string script = fmt::format("set size 0.405,0.235\nset origin {},{}\n", force ? 0.075 : 0.58, bottom);
  script += fmt::format(
      "set title '{}' offset 0,-0.6\nset xlabel '{}' offset 0,0.5\n",
      fmt::format("{}: {}", setups[row], force ? "force" : "error against the complete state space"),
      row == 2 ? "displacement of the HIP [mm]" : "");
  script += force
                ? fmt::format(
                      "set ylabel 'force [N]' offset 1,0\nunset logscale y\nset yrange [0:{:.4g}]\nset ytics "
                      "auto\nset format y '%g'\n",
                      1.6 * most)
                : std::string(
                      "set ylabel 'relative error [%]' offset 1,0\nset logscale y\nset yrange "
                      "[1e-4:1000]\nset format y '10^{%T}'\n");
  script += row == 0 && force ? "set key left top reverse Left samplen 2 font ',11'\n" : "unset key\n";
  script += "unset arrow\n";
  if (setups[row] == std::string_view("gap"))
    script += fmt::format(
        "set arrow from first {0:.6g}, graph 0 to first {0:.6g}, graph 1 nohead lw 1 dt 3 lc rgb '#8a8a8a'\n",
        1e3 * paper.far_side());
  std::string plot = "plot ";
  if (force)
    plot += "$tight using 1:2 with points pt 6 ps 0.6 lw 1.2 lc rgb '#1b1b1b' title 'tight solves', ";
  else
    plot += "7 with lines lw 1 dt 2 lc rgb '#6a6a6a' notitle, ";
  for (std::size_t m = 0; m < 3; ++m)
    plot += fmt::format("{}$c{} using 1:{} with lines lw {} lc rgb '{}' title '{}'", m > 0 ? ", " : "",
                        3 * m + row, force ? 2 : 3, m == 2 ? 2.2 : 1.6, line_colour(m),
                        fig.curves[3 * m].method.name);
  return script + plot + "\n";
}

// Three situations as rows; force and error as columns, as in the paper.
Figure picture(const Fig2& fig, const PaperStates& paper) {
  std::string script;
  double most = 0;
  std::string tight;
  for (std::size_t i = 0; i < fig.tight.size(); ++i) {
    tight += fmt::format("{:.6g} {:.6g}\n", 1e3 * fig.tight_s[i], fig.tight[i].norm());
    most = std::max(most, fig.tight[i].norm());
  }
  script += data_block("tight", tight);
  for (std::size_t c = 0; c < fig.curves.size(); ++c) {
    std::string lines;
    for (const PathPoint& p : fig.curves[c].points)
      lines += fmt::format("{:.5g} {:.6g} {:.6g}\n", 1e3 * p.s, p.force.norm(),
                           std::max(100 * p.error_complete, 1e-5));
    script += data_block(fmt::format("c{}", c), lines);
  }
  script += plot_style;
  script += fmt::format(
      "set multiplot\nset xrange [0:{:.6g}]\nset lmargin 0\nset rmargin 0\nset tmargin 0\nset bmargin 0\n",
      1e3 * paper.depth());
  for (std::size_t row = 0; row < 3; ++row)
    for (const bool force : {true, false}) script += panel(fig, paper, row, force, most);
  script += "unset multiplot\n";
  return {"extrapolation",
          "After the paper's Fig. 2. Left: force along the path; circles are tight solves. Right: error "
          "against the same method with the complete state space; dashed: the 7 % that a hand can just feel. "
          "Dotted line in the gap: start of the known states of the far side.",
          960, 940, script};
}

std::string shown(const Jump& jump) {
  return std::isfinite(jump.s)
             ? fmt::format("{:.3g} N = {:.2g} JND at {:.1f} mm", jump.size, jump.jnd, 1e3 * jump.s)
             : "none";
}

std::string shown(const Largest& most) {
  if (!(most.newton.size > 0)) return "none";
  if (most.newton.s == most.jnd.s) return shown(most.newton);
  return fmt::format("{} by force and {} by JND", shown(most.newton), shown(most.jnd));
}

std::string table(const Fig2& fig, const Judge& judge, const PaperStates& paper) {
  std::vector<std::vector<std::string>> rows{{"situation", "method", "error against tight solves: at the end",
                                              "p50", "p95", "max", "against the complete space: p50", "p95",
                                              "max", "largest jump", "in the gap alone", "far side enters",
                                              "near side leaves"}};
  for (const Curve& curve : fig.curves) {
    const auto [enters, leaves] = crossing(curve, judge);
    const bool gap = curve.setup == "gap";
    rows.push_back(
        {curve.setup, curve.method.name, percent(at_end(errors(curve, true))),
         percent(quantile_of(errors(curve, true), 0.5)), percent(quantile_of(errors(curve, true), 0.95)),
         percent(quantile_of(errors(curve, true), 1)), percent(quantile_of(errors(curve, false), 0.5)),
         percent(quantile_of(errors(curve, false), 0.95)), percent(quantile_of(errors(curve, false), 1)),
         shown(largest(curve, judge)), gap ? shown(largest(curve, judge, 0, paper.far_side())) : "",
         gap ? shown(enters) : "", gap ? shown(leaves) : ""});
  }
  return html_table(rows);
}

const Curve& curve_of(const Fig2& fig, std::string_view setup, const PathMethod& method) {
  return *std::ranges::find_if(
      fig.curves, [&](const Curve& c) { return c.setup == setup && c.method.name == method.name; });
}

std::string p50_p95_max(const std::vector<double>& values) {
  return fmt::format("{:.3g}, {:.3g} and {:.3g} %", 100 * quantile_of(values, 0.5),
                     100 * quantile_of(values, 0.95), 100 * quantile_of(values, 1));
}

std::string crossing_in_words(const Curve& gap, const Judge& judge) {
  const auto [enters, leaves] = crossing(gap, judge);
  const bool at_once = gap.points.front().far_side > 0, for_good = gap.points.back().near_side == 0;
  const std::string in = at_once ? "the far side is in the set from the beginning"
                         : std::isnan(enters.s)
                             ? "no state of the far side ever enters the set"
                             : "the force jumps by " + shown(enters) + " when the far side enters the set";
  const std::string out = !for_good || std::isnan(leaves.s)
                              ? "the near side stays in the set to the end"
                              : "by " + shown(leaves) + " when the last state of the near side leaves it";
  return in + (for_good && at_once && std::isfinite(leaves.s) ? ", the force jumps " : ", ") + out;
}

std::string what_we_found(const Fig2& fig, const Judge& judge, const PaperStates& paper) {
  std::string text = fmt::format(
      "Path of {:.3g} mm along {}, {} states in the complete space{}; the gap ends at {:.3g} mm. Errors are "
      "against tight "
      "solves, as p50, p95 and max of the path{}.",
      1e3 * paper.depth(), paper.axis(), paper.complete().size(),
      paper.unsolved() > 0 ? fmt::format(" ({} positions have no solution)", paper.unsolved()) : "",
      1e3 * paper.far_side(),
      fig.tight.size() < fig.asked
          ? fmt::format(", at the {} of {} positions that have a solution, the last at {:.3g} mm",
                        fig.tight.size(), fig.asked, fig.tight_s.empty() ? 0 : 1e3 * fig.tight_s.back())
          : "");
  for (const PathMethod& m : paper_methods()) {
    const Curve &blank = curve_of(fig, "blank", m), &sparse = curve_of(fig, "sparse", m),
                &gap = curve_of(fig, "gap", m);
    text += fmt::format(
        " {}: blank {} ({} at its end); sparse {} ({}); the path across the gap {}, the gap alone {}. There "
        "{}; the largest jump in the gap is {}.",
        m.in_words, p50_p95_max(errors(blank, true)), percent(at_end(errors(blank, true))),
        p50_p95_max(errors(sparse, true)), percent(at_end(errors(sparse, true))),
        p50_p95_max(errors(gap, true)), p50_p95_max(errors(gap, true, paper.far_side())),
        crossing_in_words(gap, judge), shown(largest(gap, judge, 0, paper.far_side())));
  }
  return text + " No switch is used: a jump is the difference of two consecutive models.";
}

// Our results that are worse than those of a kernel of the paper by more than rounding.
std::string where_worse(const Fig2& fig, const PaperStates& paper) {
  std::vector<std::string> cases;
  const auto compare = [&](const std::string& what, double ours, double theirs, const std::string& kernel) {
    if (ours > 1.005 * theirs)
      cases.push_back(fmt::format("{} {:.3g} against {:.3g} % ({})", what, 100 * ours, 100 * theirs, kernel));
  };
  for (const PathMethod& m : {linear_of_100(), cubic_of_100()})
    for (const char* area : {"blank", "sparse", "gap"}) {
      const double end = std::string_view(area) == "gap" ? paper.far_side() : INFINITY;
      const std::vector<double> ours = errors(curve_of(fig, area, our_default()), true, end),
                                theirs = errors(curve_of(fig, area, m), true, end);
      for (const auto& [name, share] : {std::pair{"p50", 0.5}, std::pair{"p95", 0.95}, std::pair{"max", 1.0}})
        compare(fmt::format("{} {}", area, name), quantile_of(ours, share), quantile_of(theirs, share),
                m.short_name);
      compare(fmt::format("{} at its end", area), at_end(ours), at_end(theirs), m.short_name);
    }
  if (cases.empty())
    return "Nowhere: in each area our p50, p95, max and error at the end are at most those of r and r3.";
  return fmt::format("Our errors that exceed those of the paper's settings: {}.", fmt::join(cases, "; "));
}

}  // namespace

Findings reproduce_extrapolation(Laboratory& laboratory, const ReproduceOptions& options,
                                 const std::filesystem::path& folder, const ShowShare& show) {
  const PaperStates paper(
      laboratory, options.depth, [&](double share, const std::string& text) { show(0.6 * share, text); },
      options.gap);
  const SessionOptions& session = laboratory.scene().session;
  const Judge judge{session.judging.error_floor, session.switching.jnd_share, session.switching.jnd_floor};
  const Fig2 fig = run_all(laboratory, paper, judge,
                           [&](double share, const std::string& text) { show(0.6 + 0.4 * share, text); });
  write_whole(folder / "extrapolation.csv", csv(fig, judge));

  Findings findings;
  findings.summary["path"] = {
      {"length", paper.depth()}, {"axis", paper.axis()}, {"spacing", paper.spacing()}};
  findings.summary["gap"] = paper.far_side();
  findings.summary["states"] = paper.complete().size();
  findings.summary["unsolved"] = paper.unsolved();
  findings.summary["tight_solves"] = {{"asked", fig.asked}, {"solved", fig.tight.size()}};
  findings.summary["curves"] = nlohmann::ordered_json::array();
  for (const Curve& curve : fig.curves)
    findings.summary["curves"].push_back(to_json(curve, judge, paper.far_side()));
  const std::string found = what_we_found(fig, judge, paper), worse = where_worse(fig, paper);
  findings.html = paragraph("The paper found",
                            "With the 100 nearest known states the error of extrapolation into a blank area "
                            "grows rapidly with the length of the "
                            "path, while few sparsely known states along it are enough for a low error. "
                            "Crossing a gap, the force changes rapidly "
                            "twice: where the first points of the other side join the nearest set, and where "
                            "the last points of the "
                            "starting side leave it.") +
                  paragraph("We found", found) + paragraph("Where ours is worse", worse) +
                  draw_into(folder, picture(fig, paper)) + table(fig, judge, paper);
  findings.lines = {found, worse};
  for (const Curve& curve : fig.curves)
    if (const Jump most = largest(curve, judge).jnd; curve.method.ours && !(most.jnd <= 1))
      findings.unmet.push_back(
          fmt::format("path of situation {}: {} jumps by {}", curve.setup, curve.method.name, shown(most)));
  return findings;
}

}  // namespace forefeel
