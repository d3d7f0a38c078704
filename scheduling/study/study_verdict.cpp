#include "scheduling/study/study_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "geometry/common/counted.hpp"
#include "scheduling/record/attention.hpp"

namespace forefeel {
namespace {

// The axis whose best value the verdict names.
std::optional<std::size_t> axis_of_verdict(const Study& study) {
  const auto competes = [&](std::size_t axis) { return study.axes[axis].values.size() > 1; };
  for (const char* policy : {"policy", "session.policy"})
    if (const auto axis = find_axis(study, policy); axis && competes(*axis)) return axis;
  std::optional<std::size_t> of_traces;
  for (std::size_t axis = 0; axis < study.axes.size(); ++axis) {
    if (!competes(axis)) continue;
    if (!is_trace_axis(study.axes[axis])) return axis;
    if (!of_traces) of_traces = axis;
  }
  return of_traces;
}

struct Contender {
  std::size_t level = 0;
  double mean = 0;  // in the metric's scale, factors as logarithms
};

// Over the traces and seeds where every contender has a value; the best first.
std::vector<Contender> contenders(const StudyAxis& axis, std::span<const Observation> seen,
                                  const StudyMetric& metric) {
  const LevelRanking ranking =
      rank(seen, axis.values.size(), metric.larger_is_better, {.shares = metric.share});
  std::vector<Contender> all;
  for (const Ranked& row : ranking.ranked)
    if (standing_of(axis, row.level) == Standing::contender && std::isfinite(row.value.student.mean))
      all.push_back({row.level, row.value.student.mean});
  return all;
}

std::string amount(const StudyMetric& metric, double mean) {
  return fmt::format("{:.3g}", metric.scale * (metric.ratio ? std::exp(mean) : mean));
}

std::string size_in_words(const StudyMetric& metric, const Comparison& d) {
  if (metric.ratio) return fmt::format("a factor {:.3g}", std::exp(d.student.mean));
  return fmt::format("{:.3g}{}", metric.scale * d.student.mean, metric.share ? " points" : "");
}

// "2.1 points, 95 % interval 0.5 to 3.7", "a factor 1.2, without an interval".
std::string difference_in_words(const StudyMetric& metric, const Comparison& d) {
  const auto size = [&](double value) {
    return metric.ratio ? fmt::format("{:.3g}", std::exp(value))
                        : fmt::format("{:.3g}", metric.scale * value);
  };
  std::string text = size_in_words(metric, d);
  if (!std::isfinite(d.student.low)) return text + ", without an interval";
  return text + fmt::format(", 95 % interval {} to {}", size(d.student.low), size(d.student.high));
}

std::string over(const Comparison& d) {
  return counted(d.pairs, "pair") + " on " + counted(d.groups, "motion");
}

bool is_shown(const Comparison& d, const StudyMetric& metric) {
  return d.groups >= fewest_motions && (metric.larger_is_better ? d.verdict() : -d.verdict()) > 0;
}

// For each contender whether the first beats it, after Holm over all of them.
std::vector<bool> beaten_after_holm(std::span<const Observation> seen, const StudyMetric& metric,
                                    const std::vector<Contender>& all) {
  std::vector<double> p_values;
  std::vector<bool> beaten;
  for (const Contender& other : all) {
    const Comparison d = compare_levels(seen, all[0].level, other.level);
    beaten.push_back(is_shown(d, metric));
    p_values.push_back(other.level == all[0].level ? std::nan("") : d.p_value());
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < all.size(); ++i) beaten[i] = beaten[i] && adjusted[i] <= significant;
  return beaten;
}

// "95 %", "52.1 mm/s"; and what that is of: " of first visits within the JND".
struct MetricWords {
  std::string unit, what;
};
MetricWords in_words(const StudyMetric& metric) {
  const std::size_t open = metric.title.rfind(" [");
  if (open == std::string::npos) return {"", metric.title};
  return {" " + metric.title.substr(open + 2, metric.title.size() - open - 3), metric.title.substr(0, open)};
}

// "coverage 98 %, nearest 95 % of first visits within the JND", at most five.
std::string best_first(const StudyAxis& axis, const StudyMetric& metric, const std::vector<Contender>& all) {
  const MetricWords words = in_words(metric);
  std::string text = metric.share ? "" : words.what + ": ";
  constexpr std::size_t most_named = 5;
  for (std::size_t i = 0; i < std::min(most_named, all.size()); ++i)
    text += fmt::format("{}{} {}{}", i > 0 ? ", " : "", axis.values[all[i].level].text,
                        amount(metric, all[i].mean), words.unit);
  return metric.share ? text + " of " + words.what : text;
}

// Those after the next that the best beats.
std::string beaten_by_best(const StudyAxis& axis, std::span<const Observation> seen,
                           const StudyMetric& metric, const std::vector<Contender>& all) {
  std::string beaten;
  const std::vector<bool> is_beaten = beaten_after_holm(seen, metric, all);
  for (std::size_t i = 2; i < all.size(); ++i)
    if (is_beaten[i]) beaten += (beaten.empty() ? "" : ", ") + axis.values[all[i].level].text;
  return beaten.empty() ? "" : fmt::format("; that to {} is significant", beaten);
}

// "2 motions are too few to compare; about 16 more would settle a difference of 5 points".
std::string too_few(const StudyMetric& metric, const Comparison& d) {
  std::string text = fmt::format("{} too few to compare", counted(d.groups, "motion is", "motions are"));
  const std::optional<std::size_t> needed = motions_needed(d);
  if (needed && *needed > d.groups)
    return text + fmt::format("; about {} more would settle a difference of {}", *needed - d.groups,
                              size_in_words(metric, d));
  return text + fmt::format("; {} is the least", fewest_motions);
}

// Why there is no winner: "the difference …".
std::string no_winner(const StudyAxis& axis, std::span<const Observation> seen, const StudyMetric& metric,
                      const std::vector<Contender>& all, const Comparison& next) {
  std::string text = fmt::format("No winner: {}", best_first(axis, metric, all));
  if (next.won == 0 && next.lost == 0) return text + fmt::format(". They are equal in all {}", over(next));
  if (next.groups < fewest_motions) return text + ". " + too_few(metric, next);
  return text + fmt::format(". The difference, {}, over {}, is not significant{}",
                            difference_in_words(metric, next), over(next),
                            beaten_by_best(axis, seen, metric, all));
}

std::string winner(const StudyAxis& axis, std::span<const Observation> seen, const StudyMetric& metric,
                   const std::vector<Contender>& all, const Comparison& next) {
  return fmt::format("Best {}: {} ({}, over {}): the difference is significant{}", axis.column,
                     best_first(axis, metric, all), difference_in_words(metric, next), over(next),
                     beaten_by_best(axis, seen, metric, all));
}

// Where first visits do not separate the two best, their error may: ". By …, …".
std::string by_second_metric(const Study& study, const std::vector<StudyCellResult>& cells,
                             std::size_t chosen, const StudyMetric& first) {
  const StudyMetric metric = second_metric(study);
  if (metric.key == first.key) return "";
  const StudyAxis& axis = study.axes[chosen];
  const std::vector<Observation> seen = observations(study, cells, chosen, metric);
  const std::vector<Contender> all = contenders(axis, seen, metric);
  if (all.size() < 2) return "";
  const Comparison next = compare_levels(seen, all[0].level, all.back().level);
  if (!is_shown(next, metric)) return "";
  return fmt::format(
      ". By {} {} is best, smaller by a factor {:.3g} (95 % interval {:.3g} to {:.3g}) than {}",
      in_words(metric).what, axis.values[all[0].level].text, std::exp(-next.student.mean),
      std::exp(-next.student.high), std::exp(-next.student.low), axis.values[all.back().level].text);
}

std::string beside_in_words(const StudyAxis& axis) {
  std::string text;
  for (const auto& [standing, why] : {std::pair{Standing::bound, "because it knows the motion"},
                                      std::pair{Standing::placebo, "because it is a placebo"}}) {
    std::string names;
    for (std::size_t level = 0; level < axis.values.size(); ++level)
      if (standing_of(axis, level) == standing)
        names += (names.empty() ? "" : ", ") + axis.values[level].text;
    if (!names.empty()) text += fmt::format(" Not compared, {}: {}.", why, names);
  }
  return text;
}

}  // namespace

std::optional<std::string> study_verdict(const Study& study, const std::vector<StudyCellResult>& cells) {
  const std::optional<std::size_t> chosen = axis_of_verdict(study);
  if (!chosen) return {};
  const StudyAxis& axis = study.axes[*chosen];
  const StudyMetric metric = primary_metric(study);
  const std::vector<Observation> seen = observations(study, cells, *chosen, metric);
  const std::vector<Contender> all = contenders(axis, seen, metric);
  if (all.empty())
    return fmt::format("No verdict on {}: no trace and seed has a value of \"{}\" for every one.",
                       axis.column, metric.title);
  std::string text;
  if (all.size() == 1) {
    text = fmt::format("Only {} competes: {}", axis.values[all[0].level].text, best_first(axis, metric, all));
  } else {
    const Comparison next = compare_levels(seen, all[0].level, all[1].level);
    text = beaten_after_holm(seen, metric, all)[1]
               ? winner(axis, seen, metric, all, next)
               : no_winner(axis, seen, metric, all, next) + by_second_metric(study, cells, *chosen, metric);
  }
  return text + "." + beside_in_words(axis);
}

// ---- advice

namespace {

constexpr double ceiling = 0.98, bottom = 0.5;  // shares: where all contenders are above, below

double mean_of(const std::vector<StudyCellResult>& cells, std::string_view column) {
  double sum = 0;
  std::size_t n = 0;
  for (const StudyCellResult& cell : cells)
    if (const double value = cell.number(column); std::isfinite(value)) {
      sum += value;
      ++n;
    }
  return n > 0 ? sum / static_cast<double>(n) : unknown;
}

std::string more_motions(const Comparison& d) {
  if (d.groups < fewest_motions)
    return fmt::format("Add motions of other kinds as values of device, {} in all at least.", fewest_motions);
  const std::optional<std::size_t> needed = motions_needed(d);
  if (!needed)
    return fmt::format(
        "More motions would hardly show it: the difference is too small beside its spread over {} motions.",
        d.groups);
  if (*needed <= d.groups)
    return "The spread over motions is small: more seeds and motions of other kinds decide.";
  constexpr std::size_t most_said = 100;
  if (*needed - d.groups > most_said)
    return fmt::format("More than {} more motions would be needed to show so small a difference.", most_said);
  return fmt::format(
      "About {} would show it with a chance of 80 %, if difference and spread stay as they are.",
      counted(*needed - d.groups, "more motion"));
}

// A load that tells the contenders apart better, from the mean load of the cells.
std::string at_load(const std::vector<StudyCellResult>& cells, double factor) {
  const double load = mean_of(cells, "load");
  if (!std::isfinite(load) || !(load > 0)) return "";
  return fmt::format(" (load now {:.2g} on average: try target_load = {:.2g})", load, factor * load);
}

std::string limits(const StudyAxis& axis, const StudyMetric& metric, const std::vector<Contender>& all,
                   const std::vector<StudyCellResult>& cells) {
  if (!metric.share) return "";
  const auto [least, most] = std::ranges::minmax(all, {}, &Contender::mean);
  if (least.mean >= ceiling)
    return fmt::format(
        "Ceiling reached: every {} is above {:g} %. Make it harder: more load, faster motions{}.",
        axis.column, 100 * ceiling, at_load(cells, 2));
  if (most.mean <= bottom)
    return fmt::format("All are poor: every {} is below {:g} %. Make it easier: less load, slower motions{}.",
                       axis.column, 100 * bottom, at_load(cells, 0.5));
  return "";
}

// The value of target_load or speed at which the two best differ most.
std::string best_load(const Study& study, const std::vector<StudyCellResult>& cells, std::size_t axis,
                      const StudyMetric& metric, const std::vector<Contender>& all) {
  for (const char* column : {"target_load", "speed"}) {
    const auto load = find_axis(study, column);
    if (!load || *load == axis || study.axes[*load].values.size() < 2) continue;
    double most = 0;
    std::string where;
    for (std::size_t value = 0; value < study.axes[*load].values.size(); ++value) {
      const Comparison d = compare_levels(observations(study, cells, axis, metric, {{*load, value}}),
                                          all[0].level, all[1].level);
      if (std::abs(d.student.mean) > most) {
        most = std::abs(d.student.mean);
        where = fmt::format(
            "The two best differ most at {} = {} ({}): look there.", column,
            study.axes[*load].values[value].text,
            metric.ratio ? fmt::format("a factor {:.3g}", std::exp(most))
                         : fmt::format("{:.3g}{}", metric.scale * most, metric.share ? " points" : ""));
      }
    }
    if (!where.empty()) return where;
  }
  return "";
}

}  // namespace

std::vector<std::string> study_advice(const Study& study, const std::vector<StudyCellResult>& cells) {
  const std::optional<std::size_t> chosen = axis_of_verdict(study);
  if (!chosen) return {};
  const StudyAxis& axis = study.axes[*chosen];
  const StudyMetric metric = primary_metric(study);
  const std::vector<Observation> seen = observations(study, cells, *chosen, metric);
  const std::vector<Contender> all = contenders(axis, seen, metric);
  if (all.size() < 2) return {};
  const Comparison next = compare_levels(seen, all[0].level, all[1].level);
  std::vector<std::string> lines;
  const auto say = [&](std::string line) {
    if (!line.empty()) lines.push_back(std::move(line));
  };
  say(limits(axis, metric, all, cells));
  if (is_shown(next, metric)) return lines;
  if (next.won + next.lost > 0) say(more_motions(next));
  say(best_load(study, cells, *chosen, metric, all));
  return lines;
}

// ---- devices

namespace {

// Mean over the cells that have a value.
class Mean {
 public:
  void add(double value, double weight = 1) {
    if (!std::isfinite(value) || !(weight > 0)) return;
    sum_ += weight * value;
    weight_ += weight;
  }
  double value() const { return weight_ > 0 ? sum_ / weight_ : unknown; }

 private:
  double sum_ = 0, weight_ = 0;
};

bool is_unstable(const StudyCellResult& cell) {
  const auto found = std::ranges::find(cell.columns(), "stability.stable", &Column::name);
  const bool* stable = found == cell.columns().end() ? nullptr : std::get_if<bool>(&found->value);
  return stable != nullptr && !*stable;
}

StudyDevice device_of(const std::string& name, const std::vector<std::size_t>& members, const StudyPlan& plan,
                      const std::vector<StudyCellResult>& cells) {
  StudyDevice device{.device = name, .cells = members.size()};
  Mean within, clamped, slewed, outside, busy, generated;
  for (const std::size_t i : members) {
    const StudyCellResult& cell = cells[i];
    device.unstable += is_unstable(cell);
    const double seconds = cell.number("seconds"), visits = cell.number("error.first_visit.samples");
    device.motion_seconds = plan.cells[i].motion_seconds;
    if (std::isfinite(seconds)) device.seconds = std::max(device.seconds, seconds);
    if (std::isfinite(visits)) device.first_visits += static_cast<std::size_t>(visits);
    within.add(cell.number("error.first_visit.within_jnd"), visits);
    clamped.add(cell.number("safety.clamped_share"));
    slewed.add(cell.number("safety.slewed_share"));
    outside.add(cell.number("time_outside"));
    busy.add(cell.number("solver.busy_share"));
    generated.add(cell.number("energy.generated_J"));
  }
  device.within_jnd = within.value();
  device.clamped = clamped.value();
  device.slewed = slewed.value();
  device.outside = outside.value();
  device.busy = busy.value();
  device.generated = generated.value();
  return device;
}

}  // namespace

std::vector<StudyDevice> study_devices(const StudyPlan& plan, const std::vector<StudyCellResult>& cells) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < plan.cells.size() && i < cells.size(); ++i) {
    const std::string name = to_text(plan.cells[i].options.motion.device);
    if (!members.contains(name)) order.push_back(name);
    members[name].push_back(i);
  }
  std::vector<StudyDevice> devices;
  for (const std::string& name : order) devices.push_back(device_of(name, members[name], plan, cells));
  return devices;
}

std::vector<std::string> attention(const std::vector<StudyDevice>& devices) {
  std::vector<std::string> lines;
  for (const StudyDevice& d : devices)
    if (d.unstable > 0)
      lines.push_back(
          fmt::format("{}: {} of {} unstable (column stability.stable): their errors are those "
                      "of a vibrating tip",
                      d.device, d.unstable, counted(d.cells, "session was", "sessions were")));
  for (const StudyDevice& d : devices) {
    if (d.clamped > clamped_too_often)
      lines.push_back(
          fmt::format("{}: {:.3g} % of the frames (mean of its sessions) were clamped at the force limit: "
                      "the device got less than was rendered",
                      d.device, 100 * d.clamped));
    if (d.outside > outside_too_often)
      lines.push_back(
          fmt::format("{}: {:.3g} % of the time (mean of its sessions) was outside the box of states: forces "
                      "there are extrapolated",
                      d.device, 100 * d.outside));
    if (d.cells > 0 && d.first_visits < few_samples)
      lines.push_back(fmt::format("{}: {} in {}: a percentage of them says little", d.device,
                                  counted(d.first_visits, "first visit"), counted(d.cells, "session")));
  }
  return lines;
}

}  // namespace forefeel
