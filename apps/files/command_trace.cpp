// forefeel trace FILE[,columns=…,rate=…,unit=…,tool=…] …: checks a recorded motion, and changes it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/spec_text.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/motion/trace_check.hpp"
#include "scheduling/motion/trace_file.hpp"

namespace forefeel {
namespace {

struct TraceArguments {
  std::string trace, offset, output, scene;
  bool to_contact = false;
  std::optional<double> from, to, rate;
};

struct Changed {
  TraceRows rows;
  std::size_t left_out = 0;  // repeated or backward rows
};

bool changes(const TraceArguments& given) {
  return given.to_contact || !given.offset.empty() || given.from || given.to || given.rate ||
         !given.output.empty();
}

void check_arguments(const TraceArguments& given) {
  if (given.to_contact && !given.offset.empty())
    throw InputError("--offset", "shifts the motion as --to-contact does, expected one of them");
  const double from = given.from.value_or(0);
  if (given.to && !(*given.to > from))
    throw InputError("--to", fmt::format("is {:g} s, expected more than --from, {:g} s", *given.to, from));
  if (given.rate && !(*given.rate >= 0.1 && *given.rate <= 1e5))
    throw InputError("--rate", fmt::format("is {:g}, expected 0.1 to 100000 Hz", *given.rate));
}

TraceRows read(const std::string& text) {
  const std::string spec = text.starts_with("trace:") ? text : "trace:" + text;
  const DeviceSpec device = device_from_text(spec);
  const auto& motion = std::get<TraceMotion>(device.motion());
  TraceRows rows = read_trace_rows(motion.file, motion.format, MissingPositions::leave_out);
  for (Vec3& x : rows.positions) x = motion.scale * x + motion.offset;
  return rows;
}

// In this order: times that grow, the window, the shift, the rate.
Changed changed(const TraceRows& rows, const TraceArguments& given) {
  Changed out{.rows = growing(rows)};
  out.left_out = rows.times.size() - out.rows.times.size();
  if (given.from || given.to) {
    try {
      out.rows = window(out.rows, given.from.value_or(0),
                        given.to.value_or(std::numeric_limits<double>::infinity()));
    } catch (const InputError& error) {
      throw InputError(given.from ? "--from" : "--to", error.problem());
    }
  }
  Vec3 shift = Vec3::Zero();
  if (given.to_contact) shift = -out.rows.positions.front();
  if (!given.offset.empty()) shift = parse_vector(given.offset, "--offset");
  for (Vec3& x : out.rows.positions) x += shift;
  if (given.rate) {
    if (out.rows.times.back() * *given.rate > 5e7)
      throw InputError("--rate", fmt::format("gives {:.3g} rows, expected at most 5e7",
                                             out.rows.times.back() * *given.rate));
    out.rows = resampled(out.rows, *given.rate);
  }
  return out;
}

void write(const std::string& output, const TraceRows& rows) {
  OutputFile file(output);
  file.write("t,x,y,z\n");
  for (std::size_t i = 0; i < rows.times.size(); ++i) {
    const Vec3& x = rows.positions[i];
    file.write(fmt::format("{},{},{},{}\n", rows.times[i], x[0], x[1], x[2]));
  }
  file.commit();
}

nlohmann::ordered_json to_json(const TraceCheck& check) {
  return {{"rows", check.rows},
          {"seconds", number(check.seconds)},
          {"rate", number(check.times.rate)},
          {"speed",
           {{"p50", number(check.speed.p50)},
            {"p95", number(check.speed.p95)},
            {"p99", number(check.speed.p99)},
            {"max", number(check.speed.max)}}},
          {"box", {vector3(check.box.low), vector3(check.box.high)}},
          {"gaps", {{"count", check.times.gaps}, {"longest", number(check.times.longest_gap)}}},
          {"repeated", check.times.repeated},
          {"backward", check.times.backward},
          {"start", number(check.start)},
          {"starts_pressed_in", check.starts_pressed_in()},
          {"outside",
           {{"share", check.outside ? number(*check.outside) : nullptr},
            {"from", check.outside_from ? number(*check.outside_from) : nullptr}}},
          {"rests",
           {{"count", check.rests.count},
            {"share", number(check.rests.share)},
            {"longest", number(check.rests.longest)},
            {"longest_from", number(check.rests.longest_from)}}}};
}

void tell(const Globals& globals, const TraceCheck& check) {
  const auto& [times, speed] = std::tie(check.times, check.speed);
  const Vec3 low = 1e3 * check.box.low, high = 1e3 * check.box.high;
  answer(globals,
         fmt::format("{} rows, {:.6g} s, {:.5g} Hz (median)", check.rows, check.seconds, times.rate));
  answer(globals, fmt::format("speed [m/s]: p50 {:.3g}, p95 {:.3g}, p99 {:.3g}, max {:.3g}", speed.p50,
                              speed.p95, speed.p99, speed.max));
  answer(globals, fmt::format("box [mm]: x {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g}", low[0],
                              high[0], low[1], high[1], low[2], high[2]));
  if (times.gaps > 0)
    answer(globals, fmt::format("{} gaps longer than three steps, the longest {:.3g} s", times.gaps,
                                times.longest_gap));
  if (times.repeated + times.backward > 0)
    answer(globals,
           fmt::format("{} rows repeat a time, {} go back in time: a session refuses them; -o leaves "
                       "them out",
                       times.repeated, times.backward));
  for (const std::string& line : trace_warnings(check)) answer(globals, line);
}

int run_trace(const Globals& globals, const TraceArguments& given) {
  check_arguments(given);
  std::optional<Box> space;
  if (!given.scene.empty())
    space = load_scene(given.scene, globals.set, nullptr, {.quiet = true}).space.box;
  else if (!globals.set.empty())
    throw InputError("--set", "is about a scene, expected --scene beside it");
  const TraceRows rows = read(given.trace);
  const std::string file = given.trace.substr(given.trace.starts_with("trace:") ? 6 : 0);
  if (!given.output.empty()) check_writable(given.output, {file.substr(0, file.find(','))});
  const bool altered = changes(given);
  const Changed result = altered ? changed(rows, given) : Changed{.rows = rows};
  const TraceCheck check = check_trace(result.rows, space);
  if (!given.output.empty()) write(given.output, result.rows);
  if (globals.json) {
    nlohmann::ordered_json document = to_json(check);
    document["missing"] = rows.missing;
    document["columns_ignored"] = rows.ignored;
    document["orientation_ignored"] = rows.orientation;
    document["left_out"] = result.left_out;
    document["file"] = given.output.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(given.output);
    print_json(document);
  } else {
    tell(globals, check);
    for (const std::string& line : trace_notes(rows)) answer(globals, line);
  }
  if (result.left_out > 0)
    warn(globals, fmt::format("{} rows whose time repeats or goes back are left out", result.left_out));
  if (!given.output.empty())
    say(globals, fmt::format("{}: {} rows t,x,y,z [s, m]", given.output, result.rows.times.size()));
  flush_warnings();
  return 0;
}

}  // namespace

void add_trace(CommandLine& line) {
  const auto given = std::make_shared<TraceArguments>();
  Command sub = line.add("trace", "Check a recorded motion; shift, cut, resample and write it");
  sub.runs([given](const Globals& globals) { return run_trace(globals, *given); });
  sub.option(
         "FILE", given->trace,
         "As in --device trace:FILE, with its settings: FILE,columns=t/x/y/z,rate=HZ,unit=mm/ms,tool=NAME. "
         "Columns are names of the header or numbers from 1; forefeel help devices")
      .required();
  sub.option("--scene", given->scene, "Also reports which share is outside the box of this scene")
      .shows("SCENE");
  sub.flag("--to-contact", given->to_contact,
           "Shifts the motion so that it starts at the contact at rest, x = 0");
  sub.option("--offset", given->offset, "Shifts the motion by this [m]").shows("X,Y,Z");
  sub.option("--from", given->from, "Leaves out rows before this time [s]").shows("T");
  sub.option("--to", given->to, "Leaves out rows after this time [s]").shows("T");
  sub.option("--rate", given->rate, "Sampling rate of the output [Hz]").shows("HZ");
  sub.option("-o,--output", given->output, "Writes t,x,y,z in s and m").shows("OUT.csv");
}

}  // namespace forefeel
