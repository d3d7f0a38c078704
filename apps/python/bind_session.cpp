#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/python/bindings.hpp"
#include "apps/python/python_parts.hpp"
#include "apps/python/scene_object.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "apps/scene/scene_session.hpp"
#include "apps/scene/spec_text.hpp"
#include "apps/session/away_from_states.hpp"
#include "apps/session/session_document.hpp"
#include "apps/session/session_states.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/field.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/motion/surface_shapes.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel::python {
namespace {

// The type of each cell of a row, and the bytes of rows of these types, without gaps.
class RowTypes final : public Cells {
 public:
  void real(double) override { types.push_back("f8"); }
  void vector(std::span<const double>) override { types.push_back("(3,)f8"); }  // three
  void whole(std::int64_t) override { types.push_back("i8"); }
  void flag(bool) override { types.push_back("?"); }
  void word(std::string_view, std::uint8_t) override { types.push_back("u1"); }
  std::vector<const char*> types;
};

class RowBytes final : public Cells {
 public:
  explicit RowBytes(void* to) : to_(static_cast<std::byte*>(to)) {}
  // Not finite: NaN, where the file has an empty cell.
  void real(double value) override { add(std::isfinite(value) ? value : unknown); }
  void vector(std::span<const double> values) override {
    for (const double value : values) real(value);
  }
  void whole(std::int64_t value) override { add(value); }
  void flag(bool value) override { add(value); }
  void word(std::string_view, std::uint8_t number) override { add(number); }

 private:
  template <class Value>
  void add(const Value& value) {
    std::memcpy(to_, &value, sizeof value);
    to_ += sizeof value;
  }
  std::byte* to_;
};

// The columns of a run's file as a structured array, also those that the file leaves out.
template <class Record>
py::array table_of(std::span<const Field<Record>> columns, const std::vector<Record>& records) {
  RowTypes of;
  py::list fields;
  for (const Field<Record>& column : columns) {
    column.put(of, Record{});
    fields.append(py::make_tuple(column.array.empty() ? column.name : column.array, of.types.back()));
  }
  py::array rows(py::dtype::from_args(fields), static_cast<py::ssize_t>(records.size()));
  RowBytes bytes(rows.mutable_data());
  for (const Record& record : records)
    for (const Field<Record>& column : columns) column.put(bytes, record);
  return rows;
}

// Of each field of such an array: its name, the columns of the file, unit and meaning.
template <class Record>
py::list names_of(std::span<const Field<Record>> columns) {
  py::list all;
  for (const Field<Record>& c : columns)
    all.append(py::make_tuple(c.array.empty() ? c.name : c.array, c.name, c.unit, c.meaning));
  return all;
}

struct Run {
  SessionResult result;
  SessionOptions options;
  std::string summary;  // summary.json
};

template <class T>
std::optional<T> taken(py::dict& given, const char* key) {
  if (!given.contains(key)) return std::nullopt;
  const py::object value = given.attr("pop")(key);
  if (value.is_none()) return std::nullopt;
  constexpr const char* expected = std::is_same_v<T, std::string> ? "a text"
                                   : std::is_floating_point_v<T>  ? "a number"
                                   : std::is_integral_v<T>        ? "a whole number"
                                                                  : "a structured array of states";
  return cast_to<T>(value, key, expected);
}

// The options of `forefeel session`, by the same names; a part may also be a Python object.
class Arguments {
 public:
  Arguments(const Scene& scene, const py::dict& given, std::shared_ptr<Failure> failure)
      : scene_(scene), given_(given.attr("copy")()), failure_(std::move(failure)) {}

  // States of a file, or of another body.
  KnownStatesArguments from = {};
  std::vector<State> foreign = {};

  void read(SessionInput& input, SessionOptions& options) {
    options = scene_.session;
    options.model.fit = scene_.model;
    input = session_input(scene_);
    if (const auto clock = taken<std::string>(given_, "clock")) {
      if (*clock != "real" && *clock != "virtual")
        throw InputError("clock", fmt::format("is '{:.40}', expected real or virtual", *clock));
      options.clock.kind = *clock == "real" ? Clock::real : Clock::virtual_time;
    }
    const bool own_motion = read_device(input, options);
    palpate(scene_, own_motion, options);
    if (is_anywhere(scene_) && !options.motion.replay) check_on_surface(options.motion.device);
    read_parts(input, options);
    read_numbers(options);
    const auto seconds = taken<double>(given_, "seconds");
    options.clock.seconds = seconds.value_or(options.clock.seconds);
    if (!seconds) options.clock.length = own_motion ? RunLength::motion : RunLength::shorter;
    read_states(input);
    for (const auto& [key, value] : given_)
      throw py::type_error(fmt::format("run_session() has no option '{:.40}'", py::cast<std::string>(key)));
  }

 private:
  void read_states(SessionInput& input) {
    from.extend = taken<bool>(given_, "extend").value_or(false);
    from.foreign = taken<bool>(given_, "foreign").value_or(false);
    const auto states = taken<py::object>(given_, "states");
    if ((from.extend && from.foreign) || (!states && (from.extend || from.foreign)))
      throw InputError(from.extend ? "extend" : "foreign",
                       "is about states, expected them, and extend or foreign");
    if (!states) return;
    if (py::isinstance<py::str>(*states)) {
      from.file = py::cast<std::string>(*states);
      return;
    }
    if (from.extend) throw InputError("extend", "appends to a file, expected its name as states");
    std::vector<State> rows =
        states_of(cast_to<py::array_t<StateRow>>(*states, "states", "a structured array of states"));
    (from.foreign ? foreign : input.known) = std::move(rows);
  }

  bool read_device(SessionInput& input, SessionOptions& options) {
    if (const auto replay = taken<std::string>(given_, "replay")) {
      options.motion.replay = *replay;
      return true;
    }
    const auto device = taken<py::object>(given_, "device");
    if (!device || py::isinstance<py::str>(*device)) {
      options.motion.device =
          device ? device_from_text(py::cast<std::string>(*device)) : forefeel::device_of(scene_);
      return device.has_value();
    }
    if (options.clock.kind == Clock::real)
      throw InputError("device", "a Python device would stop the real-time loop, expected clock=\"virtual\"");
    input.parts.device = python::device_of(*device, failure_);
    return true;
  }

  void read_parts(SessionInput& input, SessionOptions& options) {
    if (const auto policy = taken<py::object>(given_, "policy")) {
      if (py::isinstance<py::str>(*policy))
        options.planning.policy = part_from_text("policy", py::cast<std::string>(*policy));
      else
        input.parts.policy = policy_of(*policy, failure_);
    }
    if (const auto predictor = taken<py::object>(given_, "predictor")) {
      if (py::isinstance<py::str>(*predictor))
        options.motion.predictor = part_from_text("predictor", py::cast<std::string>(*predictor));
      else
        input.parts.predictor = predictor_of(*predictor, failure_);
    }
    const auto cost = taken<std::string>(given_, "cost");
    options.workers.cost = cost ? cost_from_text(*cost) : cost_of(scene_);
    if (const auto rule = taken<std::string>(given_, "switch"))
      options.switching.rule =
          chosen(*rule, "switch", std::array{SwitchRule::paper, SwitchRule::smooth, SwitchRule::none});
    if (const auto select = taken<std::string>(given_, "select"))
      options.model.fit.select = chosen(*select, "select", std::array{Select::label, Select::nearest});
  }

  void read_numbers(SessionOptions& options) {
    options.workers.count = taken<int>(given_, "workers").value_or(options.workers.count);
    options.workers.latency = taken<double>(given_, "latency").value_or(options.workers.latency);
    options.workers.threads = taken<int>(given_, "threads").value_or(0);
    options.seed = taken<std::uint64_t>(given_, "seed").value_or(options.seed);
    if (const auto arrivals = taken<std::string>(given_, "arrivals")) options.planning.arrivals = *arrivals;
  }

  const Scene& scene_;
  py::dict given_;
  std::shared_ptr<Failure> failure_;
};

std::unique_ptr<Run> run(const PyScene& scene, const std::function<void(double)>& progress,
                         const py::dict& given) {
  const auto failure = std::make_shared<Failure>();
  auto made = std::make_unique<Run>();
  SessionInput input;
  Arguments arguments(*scene.scene, given, failure);
  arguments.read(input, made->options);
  {
    const py::gil_scoped_release released;
    Globals globals;
    globals.quiet = true;
    globals.threads = made->options.workers.threads;
    const std::optional<SessionField> field = touch_anywhere(*scene.scene, globals, input);
    if (field) input.known = states_for_touch(input, std::move(input.known));
    SessionPlan plan = make_plan(input, made->options);
    if (!arguments.from.file.empty())
      plan = take_states(*scene.scene, arguments.from, {}, globals, std::move(plan));
    else if (arguments.from.foreign)
      plan = take_foreign(*scene.scene, "states", std::move(arguments.foreign), globals, std::move(plan));
    plan.options.stop.interrupted = &failure->raised();
    const auto show = [&](const SessionProgress& p) {
      const py::gil_scoped_acquire locked;
      try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (progress && p.seconds > 0) progress(p.t / p.seconds);
      } catch (...) {
        failure->keep(std::current_exception());
      }
    };
    PredictorScores predictions(plan.options.clock.frame, plan.options.motion.predictor,
                                factory_context(plan.input, plan.options.seed));
    made->result =
        run_session(plan, {.progress = show, .each_position = [&](const Vec3& at) { predictions.add(at); }});
    const SessionSummary::AwayFromStates away = away_from_states(made->result, plan, [] {});
    made->options = plan.options;
    made->options.stop = {};
    const bool measures = !made->result.interrupted() && !plan.input.foreign;
    const MeshError mesh = measures ? MeshErrorTask(*scene.scene, MeshErrorTask::When::at_the_end).get()
                                    : MeshError{.why = "the session was interrupted"};
    made->summary = json_text(session_document(whole_summary(made->result, plan, predictions, away, mesh),
                                               made->result, *scene.scene, field));
  }
  failure->throw_again();
  return made;
}

}  // namespace

void bind_session(py::module_& module) {
  bind_parts(module);
  module.attr("_run_fields") =
      py::make_tuple(names_of(frame_columns()), names_of(dispatch_columns()), names_of(switch_columns()));
  py::list statuses, causes;
  for (int i = 0; i <= static_cast<int>(DispatchStatus::withdrawn); ++i)
    statuses.append(std::string(name(static_cast<DispatchStatus>(i))));
  for (int i = 0; i <= static_cast<int>(SwitchCause::travel); ++i)
    causes.append(std::string(name(static_cast<SwitchCause>(i))));
  module.attr("dispatch_status_names") = py::tuple(statuses);
  module.attr("switch_cause_names") = py::tuple(causes);
  py::class_<Run>(module, "Run")
      .def_property_readonly("frames",
                             [](const Run& self) { return table_of(frame_columns(), self.result.frames); })
      .def_property_readonly(
          "dispatches", [](const Run& self) { return table_of(dispatch_columns(), self.result.dispatch); })
      .def_property_readonly("switches",
                             [](const Run& self) { return table_of(switch_columns(), self.result.switches); })
      .def_property_readonly("states", [](const Run& self) { return array_of(self.result.states); })
      .def_property_readonly("interrupted", [](const Run& self) { return self.result.interrupted(); })
      .def_property_readonly("_summary", [](const Run& self) { return self.summary; })
      .def(
          "write",
          [](const Run& self, const std::filesystem::path& folder) {
            const py::gil_scoped_release released;
            prepare_run_folder(folder);
            write_run_files(folder, self.result, self.options);
          },
          py::arg("folder"));
  module.def("_run_session", &run, py::arg("scene"), py::arg("progress"), py::arg("options"));
}

}  // namespace forefeel::python
