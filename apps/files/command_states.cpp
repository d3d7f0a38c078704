// forefeel import and export: read states from a table, write them as a table or for ParaView.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/spacing_check.hpp"
#include "apps/console/units.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/mesh/length_unit.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/named_columns.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_summary.hpp"

namespace forefeel {
namespace {

// ---- import ----------------------------------------------------------------------------------------------

struct ImportArguments {
  std::string input, output, unit = "m", columns;
  std::optional<double> spacing = {};
};

// Lengths of the file in another unit: positions, spacings, and the stiffness in N per unit.
void take_in(std::vector<State>& states, double metres) {
  for (State& state : states) {
    if (state.jet)
      throw InputError("--unit", "is for states without energy jets, whose columns are in SI units");
    state.at *= metres;
    state.spacing *= metres;
    state.stiffness /= metres;
  }
}

// An imported file may be imported again. A file with solved states is never overwritten.
void refuse_solved(const std::string& output) {
  std::error_code error;
  if (!std::filesystem::exists(output, error) || std::filesystem::file_size(output, error) == 0) return;
  const StateFile file = StateFile::open_read_only(output);
  const auto source = file.header().notes.find("source");
  if (file.size() > 0 && (source == file.header().notes.end() || !source->second.starts_with("import")))
    throw InputError(
        output,
        fmt::format("already holds {} states that were not imported, expected a new name", file.size()));
}

double spacing_of(const ImportArguments& arguments, std::span<const State> states) {
  const double spacing = arguments.spacing.value_or(estimate_spacing(states));
  if (!(spacing > 0))
    throw InputError(arguments.input, "has too few places to estimate a spacing, expected --spacing METRES");
  return spacing;
}

int run_import(const Globals& globals, const ImportArguments& arguments) {
  if (arguments.spacing && (!(*arguments.spacing > 0) || !std::isfinite(*arguments.spacing)))
    throw InputError("--spacing", fmt::format("{} m, expected a positive number", *arguments.spacing));
  Progress progress(globals, "import");
  progress.show("reading " + arguments.input);
  StateTable table = arguments.columns.empty()
                         ? read_table_csv(arguments.input)
                         : read_table_csv(arguments.input, named_columns(arguments.columns));
  std::vector<State>& states = table.states;
  if (const double metres = unit_of(arguments.unit).value_or(1); metres != 1) take_in(states, metres);
  check_appendable(arguments.output, {arguments.input});
  refuse_solved(arguments.output);
  StateFileHeader header;
  progress.show("spacing");
  header.spacing = spacing_of(arguments, states);
  const StateSetSummary sum = summarise(states);
  header.box = sum.extent;
  if (const auto line = spacing_beyond("--spacing", header.spacing, header.box, "the states"))
    warn(globals, *line);
  progress.show("checking the forces");
  if (table.tells == Tells::force)
    for (const std::string& problem : misleading(states, header.spacing))
      warn(globals, fmt::format("{}: {}", arguments.input, problem));
  else
    header.notes[tells_note] = table.tells == Tells::value ? "value" : "places";
  if (!table.value.empty()) header.notes[value_note] = table.value;
  header.notes["source"] = "import " + arguments.input;
  progress.show("writing " + arguments.output);
  StateFile file = StateFile::open_or_create(arguments.output, header);
  file.replace(header, states);
  const RepeatedStates& repeats = sum.at_one_position;
  if (const std::string line = contradictions_in_words(arguments.input, repeats, states); !line.empty())
    warn(globals, line);
  else if (repeats.contradicting == 0 && repeats.repeated > 0)
    warn(globals, fmt::format("{}: {} duplicate positions with the same force; each counts once",
                              arguments.input, repeats.repeated));
  if (globals.json)
    print_json({{"states", states.size()},
                {"with_stiffness", sum.with_stiffness},
                {"repeated", repeats.repeated},
                {"contradicting", repeats.contradicting},
                {"averaged", repeats.averaged},
                {"largest_difference", repeats.largest_difference},
                {"spacing", number(header.spacing)},
                {"spacing_estimated", !arguments.spacing},
                {"box", {vector3(header.box.low), vector3(header.box.high)}},
                {"file", arguments.output}});
  say(globals,
      fmt::format("{}: {}, spacing {}{}", arguments.output,
                  table.tells == Tells::places ? counted(states.size(), "place") + " without forces"
                  : table.tells == Tells::value
                      ? counted(states.size(), "value")
                      : fmt::format("{} states, {} with stiffness", states.size(), sum.with_stiffness),
                  Units(header.spacing).distance(header.spacing), arguments.spacing ? "" : " (estimated)"));
  return 0;
}

// ---- export ----------------------------------------------------------------------------------------------

struct ExportArguments {
  std::string input, output;
};

int run_export(const Globals& globals, const ExportArguments& arguments) {
  const std::string extension = lower_case(std::filesystem::path(arguments.output).extension().string());
  if (extension != ".csv" && extension != ".vtu")
    throw InputError(arguments.output, "expected a name that ends in .csv or .vtu");
  check_writable(arguments.output, {arguments.input});
  Progress progress(globals, "export");
  progress.show("reading " + arguments.input);
  const LoadedStates loaded = load_states(arguments.input, Tells::places);
  if (loaded.damaged > 0) warn(globals, damage_in_words(arguments.input, loaded.damaged));
  progress.show("writing " + arguments.output);
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(loaded.states, &State::usable));
  const std::size_t written = extension == ".csv" ? usable : loaded.states.size();
  if (extension == ".csv")
    write_states_csv(arguments.output, loaded.states);
  else
    write_states_vtu(arguments.output, loaded.states);
  if (globals.json)
    print_json({{"states", loaded.states.size()},
                {"written", written},
                {"failed_left_out", loaded.states.size() - written},
                {"file", arguments.output}});
  say(globals, fmt::format("{}: {} states{}", arguments.output, written,
                           written < loaded.states.size()
                               ? fmt::format(", {} that failed left out", loaded.states.size() - written)
                               : ""));
  return 0;
}

}  // namespace

void add_import(CommandLine& line) {
  auto arguments = std::make_shared<ImportArguments>();
  Command sub =
      line.add("import", "Convert states from a CSV, measured or from elsewhere, into a state file");
  sub.reads_no_scene();
  sub.runs([arguments](const Globals& globals) { return run_import(globals, *arguments); });
  sub.option("CSV", arguments->input,
             "Columns x,y,z,fx,fy,fz[,k11,…,k33][,h][,sx,sy,sz], the last three the site of each state; or "
             "x,y,z, or x,y,z and one value")
      .required()
      .shows("F.csv");
  sub.option("-o,--output", arguments->output, "State file to write").required().shows("S.states");
  sub.option("--spacing", arguments->spacing,
             "Distance between states at which you call the space densely known [m]; default: estimated")
      .shows("H");
  sub.option(
         "--columns", arguments->columns,
         "Names of the columns of x, y, z, fx, fy and fz, where the file has others; a - before a name "
         "turns the sign. The force is that of the body on the tip. Three names: places alone; four: places "
         "and one value")
      .shows("X,Y,Z[,FX,FY,FZ]");
  sub.option("--unit", arguments->unit,
             "Unit of the file's lengths: x, y, z and h are in it, k11 to k33 in N per unit. Default: m")
      .one_of({"m", "cm", "mm", "um"});
}

void add_export(CommandLine& line) {
  auto arguments = std::make_shared<ExportArguments>();
  Command sub = line.add("export", "Write states as a table or for ParaView");
  sub.reads_no_scene();
  sub.runs([arguments](const Globals& globals) { return run_export(globals, *arguments); });
  sub.option("STATES", arguments->input, "State file or CSV").required().shows("STATES");
  sub.option("-o,--output", arguments->output, "File to write").required().shows("F.csv|F.vtu");
}

}  // namespace forefeel
