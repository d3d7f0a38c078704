// The paper's Fig. 3. The HIP is held in a blank area while groups of states become known, the most distant
// first, until the space is full. Shows how each group changes the force, without and with damping, with the
// paper's settings and with ours. The runs are sessions under the virtual clock with given arrivals; planner
// and loop are those of any session.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"
#include "apps/laboratory/paper_states.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/record/run_files.hpp"

namespace forefeel {
namespace {

constexpr std::size_t groups = 8;
constexpr double approach_speed = 0.05;  // of the HIP on its way there [m/s]

struct Way {
  std::string name;
  PathMethod method;
  SwitchRule rule;
};

std::vector<Way> ways() {
  return {{"paper (r3), undamped", cubic_of_100(), SwitchRule::none},
          {"paper (r3), damped", cubic_of_100(), SwitchRule::paper},
          {"ours, undamped", our_default(), SwitchRule::none},
          {"ours, smooth", our_default(), SwitchRule::smooth}};
}

struct Script {
  double held_at = 0;                           // s of the HIP [m]
  double first = 0, interval = 0, seconds = 0;  // of the groups [s]
  std::vector<State> known;
  std::vector<std::vector<Vec3>> arriving;  // by group, the most distant first
};

// Groups of equal size, divided by distance from the HIP.
Script write_script(const PaperStates& paper, const ReproduceOptions& options) {
  Script script;
  script.held_at = 0.775 * paper.depth();  // not a lattice point
  script.interval = options.interval;
  script.first = std::max(options.interval, script.held_at / approach_speed + 0.5);
  script.seconds = script.first + static_cast<double>(groups) * options.interval;
  script.known = paper.known("blank");
  std::vector<Vec3> rest;
  for (const State& state : paper.complete())
    if (paper.along(state.at) > 0.5 * paper.spacing()) rest.push_back(state.at);
  const Vec3 hip = paper.at(script.held_at);
  std::ranges::stable_sort(
      rest, [&](const Vec3& a, const Vec3& b) { return (a - hip).norm() > (b - hip).norm() + 1e-9; });
  script.arriving.resize(groups);
  for (std::size_t i = 0; i < rest.size(); ++i) script.arriving[i * groups / rest.size()].push_back(rest[i]);
  return script;
}

void write_inputs(const Script& script, const PaperStates& paper, const std::filesystem::path& folder) {
  std::string arrivals = "t,x,y,z\n", trace = "t,x,y,z\n";
  for (std::size_t g = 0; g < groups; ++g)
    for (const Vec3& x : script.arriving[g])
      arrivals += fmt::format("{},{},{},{}\n", script.first + static_cast<double>(g) * script.interval, x[0],
                              x[1], x[2]);
  const double arrived = script.held_at / approach_speed;
  for (int i = 0; i <= 20; ++i) {  // speed is zero at both ends
    const double u = i / 20.0;
    const Vec3 x = paper.at(script.held_at * u * u * (3 - 2 * u));
    trace += fmt::format("{:.6g},{:.9g},{:.9g},{:.9g}\n", arrived * u, x[0], x[1], x[2]);
  }
  write_whole(folder / "damping-arrivals.csv", arrivals);
  write_whole(folder / "damping-motion.csv", trace);
}

struct Run {
  Way way;
  std::vector<FrameRecord> frames;
};

std::vector<Run> run_ways(Laboratory& laboratory, const PaperStates& paper, const Script& script,
                          const std::filesystem::path& folder, const ShowShare& show) {
  laboratory.service()->learn(paper.complete());
  SessionInput input = laboratory.session_input();
  input.known = script.known;
  input.touched.space = paper.space({}).options();
  std::vector<Run> runs;
  for (const Way& way : ways()) {
    SessionOptions options = laboratory.scene().session;
    options.clock.kind = Clock::virtual_time;
    options.clock.seconds = script.seconds;
    options.motion.device = TraceMotion{.file = std::filesystem::absolute(folder / "damping-motion.csv")};
    options.planning.arrivals = folder / "damping-arrivals.csv";
    options.motion.replay.reset();
    options.model.fit = way.method.model;
    options.model.method = SessionMethod::rbf;
    options.switching.rule = way.rule;
    options.workers.cost = ConstantCost{};
    options.workers.threads = laboratory.globals().threads;
    options.judging.reference_step = 1;  // the HIP rests: one reference is enough, below
    const double done = static_cast<double>(runs.size()) / 4;
    SessionResult result = run_session(input, options, {.progress = [&](const SessionProgress& p) {
                                         show(done + 0.25 * (p.seconds > 0 ? p.t / p.seconds : 0),
                                              fmt::format("{}: {}", way.name, phase_in_words(p)));
                                       }});
    runs.push_back({way, std::move(result.frames)});
  }
  return runs;
}

// ---- results

struct Threshold {
  double share, absolute;  // of the JND
  double jnd(const Vec3& force) const { return std::max(share * force.norm(), absolute); }
};

// Results of group g: from its arrival to the next group's.
struct Effect {
  double jump = 0, jump_jnd = 0;  // |f~' - f~| at a change of model [N]
  double frame = 0,
         frame_share = 0;    // largest change of the force between two frames [N], and relative to |F|
  double settled = unknown;  // time until the force equals the newest model's [s]
};

std::array<Effect, groups> effects(const Run& run, const Script& script, const Threshold& judge) {
  std::array<Effect, groups> found;
  for (std::size_t k = 1; k < run.frames.size(); ++k) {
    const FrameRecord &a = run.frames[k - 1], &b = run.frames[k];
    const double since = b.t - script.first + 1e-9;
    if (since < 0) continue;
    const auto g = std::min(groups - 1, static_cast<std::size_t>(since / script.interval));
    Effect& e = found[g];
    e.jump = std::max(e.jump, b.step.undamped_jump);
    e.jump_jnd = std::max(e.jump_jnd, b.step.undamped_jump / judge.jnd(b.undamped));
    const double change = (b.force - a.force).norm();
    e.frame = std::max(e.frame, change);
    e.frame_share = std::max(e.frame_share, change / std::max(a.force.norm(), judge.absolute));
    const bool settled = (b.force - b.undamped).norm() < 1e-9;
    if (!settled)
      e.settled = unknown;
    else if (std::isnan(e.settled))
      e.settled = since - static_cast<double>(g) * script.interval;
  }
  return found;
}

struct Reading {
  std::array<Effect, groups> effects;
  double jump = 0, jump_jnd = 0, frame = 0, frame_share = 0, settled = 0;
  std::size_t unsettled = 0;   // groups whose model was not reached before the next group came
  std::size_t over_bound = 0;  // frames in which the switch changes the force by more than the rule allows
  double start_error = unknown, end_error = unknown;  // before the first group; at the end
  double worst_error = unknown;                       // of the newest model, while groups arrive
};

Reading read(const Run& run, const Script& script, const Threshold& judge, const State& tight, double floor) {
  Reading reading;
  reading.effects = effects(run, script, judge);
  for (const Effect& e : reading.effects) {
    reading.jump = std::max(reading.jump, e.jump);
    reading.jump_jnd = std::max(reading.jump_jnd, e.jump_jnd);
    reading.frame = std::max(reading.frame, e.frame);
    reading.frame_share = std::max(reading.frame_share, e.frame_share);
    if (std::isfinite(e.settled))
      reading.settled = std::max(reading.settled, e.settled);
    else
      ++reading.unsettled;
  }
  for (const FrameRecord& frame : run.frames)
    if (frame.t >= script.first - 1e-9 && frame.step.change > frame.step.bound) ++reading.over_bound;
  if (!tight.usable()) return reading;
  const auto error = [&](const FrameRecord& f) {
    return (f.force - tight.force).norm() / std::max(tight.force.norm(), floor);
  };
  for (const FrameRecord& frame : run.frames)
    if (frame.t < script.first - 1e-9)
      reading.start_error = error(frame);
    else
      reading.worst_error =
          std::max(std::isnan(reading.worst_error) ? 0 : reading.worst_error,
                   (frame.undamped - tight.force).norm() / std::max(tight.force.norm(), floor));
  reading.end_error = error(run.frames.back());
  return reading;
}

nlohmann::ordered_json to_json(const Run& run, const Reading& reading) {
  nlohmann::ordered_json row;
  row["method"] = run.way.name;
  row["switch"] = name(run.way.rule);
  row["max_jump"] = {{"newton", number(reading.jump)}, {"jnd", number(reading.jump_jnd)}};
  row["max_frame_change"] = {{"newton", number(reading.frame)}, {"share", number(reading.frame_share)}};
  row["settled_after"] = number(reading.settled);
  row["groups_unsettled"] = reading.unsettled;
  row["frames_over_bound"] = reading.over_bound;
  row["error_before"] = number(reading.start_error);
  row["error_after"] = number(reading.end_error);
  row["error_worst"] = number(reading.worst_error);
  row["groups"] = nlohmann::ordered_json::array();
  for (const Effect& e : reading.effects)
    row["groups"].push_back({{"jump", number(e.jump)},
                             {"jump_jnd", number(e.jump_jnd)},
                             {"frame_change", number(e.frame)},
                             {"frame_share", number(e.frame_share)},
                             {"settled_after", number(e.settled)}});
  return row;
}

// ---- files

// Every 50th frame, and every frame in the second after a group.
bool is_kept(std::size_t k, double t, const Script& script) {
  if (k % 50 == 0) return true;
  const double since = t - script.first + 0.01;
  return since >= 0 && std::fmod(since, script.interval) < std::min(1.0, 0.5 * script.interval);
}

double share_of_change(const Run& run, std::size_t k) {
  if (k == 0) return 0;
  return (run.frames[k].force - run.frames[k - 1].force).norm() /
         std::max(run.frames[k - 1].force.norm(), 0.01);
}

std::string csv(const std::vector<Run>& runs, const Script& script) {
  std::string text = "method,t,known,label,force,fx,fy,fz,undamped,change,change_share\n";
  for (const Run& run : runs)
    for (std::size_t k = 0; k < run.frames.size(); ++k) {
      const FrameRecord& f = run.frames[k];
      if (!is_kept(k, f.t, script)) continue;
      const double change = k > 0 ? (f.force - run.frames[k - 1].force).norm() : 0;
      text += fmt::format("\"{}\",{:.6g},{},{},{:.8g},{:.8g},{:.8g},{:.8g},{:.8g},{:.4g},{:.4g}\n",
                          run.way.name, f.t, f.known, name(f.label), f.force.norm(), f.force[0], f.force[1],
                          f.force[2], f.undamped.norm(), change, share_of_change(run, k));
    }
  return text;
}

std::size_t worst_group(const Reading& reading) {
  std::size_t worst = 0;
  for (std::size_t g = 0; g < groups; ++g)
    if (reading.effects[g].jump > reading.effects[worst].jump) worst = g;
  return worst;
}

// Force over the session; relative change from frame to frame; and the second after the worst group.
Figure picture(const std::vector<Run>& runs, const std::vector<Reading>& readings, const Script& script,
               const State& tight) {
  const double zoom = script.first + static_cast<double>(worst_group(readings[0])) * script.interval;
  const double span = std::min(1.0, 0.5 * script.interval);
  std::string out;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::vector<double> t, force, change;
    std::string near;
    for (std::size_t k = 0; k < runs[r].frames.size(); ++k) {
      const FrameRecord& f = runs[r].frames[k];
      t.push_back(f.t);
      force.push_back(f.force.norm());
      change.push_back(std::max(1e-4, 100 * share_of_change(runs[r], k)));
      if (f.t >= zoom - 0.1 * span && f.t <= zoom + span)
        near += fmt::format("{:.6g} {:.7g}\n", 1e3 * (f.t - zoom), f.force.norm());
    }
    out += data_block(fmt::format("f{}", r), thinned_curve(t, force, 1500));
    out += data_block(fmt::format("c{}", r), thinned_curve(t, change, 1500));
    out += data_block(fmt::format("z{}", r), near);
  }
  const std::array<std::size_t, 3> shown{0, 1, 3};
  const auto curves = [&](char block, const char* style) {
    std::string plot;
    for (std::size_t i = 0; i < shown.size(); ++i)
      plot += fmt::format("{}${}{} using 1:2 with {} lc rgb '{}' title '{}'", i > 0 ? ", " : "", block,
                          shown[i], style, line_colour(i), runs[shown[i]].way.name);
    return plot;
  };
  out += plot_style;
  out += fmt::format(
      "set multiplot\nset lmargin 0\nset rmargin 0\nset tmargin 0\nset bmargin 0\nset xrange [0:{}]\nset "
      "xlabel 'time [s]' offset 0,0.5\n",
      script.seconds);
  out +=
      "set size 0.905,0.31\nset origin 0.08,0.625\nset ylabel 'force [N]' offset 1,0\nset yrange [0:*]\nset "
      "key at screen 0.53,0.99 center top horizontal samplen 2 maxrows 1\n";
  const std::string line =
      tight.usable() ? fmt::format("{:.7g} with lines lw 1 dt 2 lc rgb '#6a6a6a' title 'tight solve', ",
                                   tight.force.norm())
                     : "";
  out += "plot " + line + curves('f', "lines lw 1.6") + "\n";
  out +=
      "unset key\nset size 0.52,0.38\nset origin 0.08,0.09\nset logscale y\nset yrange [1e-4:1000]\nset "
      "format y '10^{%T}'\nset ylabel 'change from frame to frame [%]' offset 1,0\n";
  out += "plot 7 with lines lw 1 dt 2 lc rgb '#6a6a6a' notitle, " + curves('c', "lines lw 1.4") + "\n";
  out += fmt::format(
      "unset logscale y\nset format y '%g'\nset yrange [*:*]\nset size 0.285,0.38\nset origin "
      "0.685,0.09\nset xrange [{:.5g}:{:.5g}]\n"
      "set xlabel 'time after the group at {:.4g} s [ms]'\nset ylabel 'force [N]' offset 1,0\n",
      -100 * span, 1e3 * span, zoom);
  out += "plot " + curves('z', "lines lw 2") + "\nunset multiplot\n";
  return {"damping",
          "After the paper's Fig. 3. Top: the force while the HIP is held and groups of states become known. "
          "Bottom left: its relative change between frames of 1 ms (dashed: 7 %). Bottom right: the force "
          "around the group with the largest jump.",
          960, 640, out};
}

std::string table(const std::vector<Run>& runs, const std::vector<Reading>& readings) {
  std::vector<std::vector<std::string>> rows{{"method", "largest jump between models", "in JND",
                                              "largest change in a frame", "relative", "settled within",
                                              "frames over the bound", "error before", "worst", "after"}};
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Reading& x = readings[r];
    rows.push_back({runs[r].way.name, fmt::format("{:.3g} N", x.jump), fmt::format("{:.3g}", x.jump_jnd),
                    fmt::format("{:.3g} N", x.frame), percent(x.frame_share),
                    x.unsettled > 0 ? fmt::format("{:.0f} ms, {} not", 1e3 * x.settled, x.unsettled)
                                    : fmt::format("{:.0f} ms", 1e3 * x.settled),
                    fmt::format("{}", x.over_bound), percent(x.start_error), percent(x.worst_error),
                    percent(x.end_error)});
  }
  return html_table(rows);
}

std::string what_we_found(const std::vector<Run>& runs, const std::vector<Reading>& readings,
                          const Script& script) {
  const Reading &bare = readings[0], &damped = readings[1], &ours = readings[3];
  return fmt::format(
      "The HIP was held {:.3g} mm beyond the slab while {} groups of about {} states came every {:.3g} s. "
      "With the paper's settings and no damping, the force jumped at a group by up to {:.3g} N, {:.3g} JND "
      "and {} of the force in one frame (largest values over all groups). The paper's damped switch finished "
      "{} within {:.0f} ms; no frame changed the force by more than {}. With ours, consecutive models differ "
      "by at most {:.3g} N and {:.2g} JND, and under the smooth switch no frame changed the force by more "
      "than {} ({} frames over its bound of 0.7 % or 1 mN per frame). The error at the HIP went from {} to "
      "{} "
      "({} to {} with {}). While groups came it was at most {} ({}).{}",
      1e3 * script.held_at, groups, script.arriving.front().size(), script.interval, bare.jump, bare.jump_jnd,
      percent(bare.frame_share),
      damped.unsettled == 0 ? "every group"
                            : fmt::format("{} of {} groups (the others not before the next group)",
                                          groups - damped.unsettled, groups),
      1e3 * damped.settled, percent(damped.frame_share), ours.jump, ours.jump_jnd, percent(ours.frame_share),
      ours.over_bound, percent(ours.start_error), percent(ours.end_error), percent(bare.start_error),
      percent(bare.end_error), runs[0].way.method.name, percent(ours.worst_error), percent(bare.worst_error),
      ours.jump > bare.jump
          ? " With this order of arrival, the farthest first, our models differ by more than the paper's. "
            "The switch decides how much of the difference passes in one frame."
          : "");
}

}  // namespace

Findings reproduce_damping(Laboratory& laboratory, const ReproduceOptions& options,
                           const std::filesystem::path& folder, const ShowShare& show) {
  const PaperStates paper(laboratory, options.depth,
                          [&](double share, const std::string& text) { show(0.4 * share, text); });
  const Script script = write_script(paper, options);
  write_inputs(script, paper, folder);
  const SessionOptions& session = laboratory.scene().session;
  const Threshold judge{session.switching.jnd_share, session.switching.jnd_floor};
  const State tight = laboratory.references(std::array{paper.at(script.held_at)}).front();
  const std::vector<Run> runs =
      run_ways(laboratory, paper, script, folder,
               [&](double share, const std::string& text) { show(0.4 + 0.6 * share, text); });
  std::vector<Reading> readings;
  for (const Run& run : runs)
    readings.push_back(read(run, script, judge, tight, session.judging.error_floor));
  write_whole(folder / "damping.csv", csv(runs, script));

  Findings findings;
  findings.summary["held_at"] = script.held_at;
  findings.summary["interval"] = script.interval;
  findings.summary["groups"] = groups;
  findings.summary["states"] = paper.complete().size();
  findings.summary["runs"] = nlohmann::ordered_json::array();
  for (std::size_t r = 0; r < runs.size(); ++r)
    findings.summary["runs"].push_back(to_json(runs[r], readings[r]));
  const std::string found = what_we_found(runs, readings, script);
  findings.html = paragraph("The paper found",
                            "With the HIP held where nothing is known and groups of states arriving every 10 "
                            "s, the most distant first, the change of force at "
                            "each arrival exceeds the just noticeable difference by far without damping; "
                            "moving the weight between old and new coefficients "
                            "every tenth frame by at most 7 % spreads each jump over several frames.") +
                  paragraph("We found", found) + draw_into(folder, picture(runs, readings, script, tight)) +
                  table(runs, readings);
  findings.lines = {found};
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (runs[r].way.rule != SwitchRule::none && readings[r].over_bound > 0)
      findings.unmet.push_back(fmt::format("{}: {} frames change by more than the rule's bound",
                                           runs[r].way.name, readings[r].over_bound));
  return findings;
}

}  // namespace forefeel
