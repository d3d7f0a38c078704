// Reads RUN/session.inputs, all that came into a run.

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "apps/python/arrays.hpp"
#include "apps/python/bindings.hpp"
#include "geometry/states/state_message.hpp"
#include "scheduling/render/input_format.hpp"

namespace forefeel::python {
namespace {

struct FrameInputRow {
  std::uint32_t frame, known;
  std::uint64_t model;
  bool ended, held;
  double started, now, beat, at[3], rendered[3], sent[3];
};

struct ModelInputRow {
  double hip[3];
  std::uint32_t states;
  std::uint64_t serial;
  bool published;
};

struct Inputs {
  InputHeader header = {};
  bool whole = false;
  std::vector<FrameInput> frames = {};
  std::vector<ModelInput> models = {};
  std::vector<State> states = {}, failed = {};
};

void take(Inputs& inputs, InputKind kind, Unpacker content) {
  if (kind == InputKind::frame)
    inputs.frames.push_back(unpack_frame(content));
  else if (kind == InputKind::model)
    inputs.models.push_back(unpack_model(content));
  else if (kind == InputKind::state)
    inputs.states.push_back(unpack_state(content));
  else if (kind == InputKind::failed)
    inputs.failed.push_back(unpack_state(content));
}

Inputs read_all(const std::filesystem::path& file) {
  InputReader reader(file);
  Inputs inputs{.header = reader.header()};
  while (const auto record = reader.next()) {
    try {
      take(inputs, record->kind, Unpacker(record->content));
    } catch (const MalformedMessage& problem) {
      reader.refuse(*record, problem.what());
    }
  }
  inputs.whole = reader.whole();
  return inputs;
}

py::array_t<FrameInputRow> rows_of(const std::vector<FrameInput>& frames) {
  py::array_t<FrameInputRow> rows = zero_rows<FrameInputRow>(frames.size());
  FrameInputRow* row = rows.mutable_data();
  for (const FrameInput& f : frames) {
    row->frame = f.frame, row->known = f.known, row->model = f.model;
    row->ended = f.ended, row->held = f.held;
    row->started = f.started, row->now = f.now, row->beat = f.beat;
    std::copy_n(f.at.data(), 3, row->at);
    std::copy_n(f.rendered.data(), 3, row->rendered);
    std::copy_n(f.sent.data(), 3, row->sent);
    ++row;
  }
  return rows;
}

py::array_t<ModelInputRow> rows_of(const std::vector<ModelInput>& models) {
  py::array_t<ModelInputRow> rows = zero_rows<ModelInputRow>(models.size());
  ModelInputRow* row = rows.mutable_data();
  for (const ModelInput& m : models) {
    std::copy_n(m.hip.data(), 3, row->hip);
    row->states = m.states, row->serial = m.serial, row->published = m.published;
    ++row;
  }
  return rows;
}

py::dict read_inputs(const std::filesystem::path& file) {
  Inputs inputs;
  {
    const py::gil_scoped_release released;
    inputs = read_all(file);
  }
  py::dict out;
  out["made_by"] = inputs.header.made_by;
  out["clock"] = inputs.header.real ? "real" : "virtual";
  out["frame_seconds"] = inputs.header.render.frame;
  out["frames_planned"] = inputs.header.frames;
  out["spacing"] = inputs.header.space.spacing;
  out["box"] = array_of(inputs.header.space.box);
  out["whole"] = inputs.whole;
  out["frames"] = rows_of(inputs.frames);
  out["models"] = rows_of(inputs.models);
  out["states"] = array_of(std::span<const State>(inputs.states));
  out["failed"] = array_of(std::span<const State>(inputs.failed));
  return out;
}

}  // namespace

void bind_inputs(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(FrameInputRow, frame, known, model, ended, held, started, now, beat, at, rendered,
                       sent);
  PYBIND11_NUMPY_DTYPE(ModelInputRow, hip, states, serial, published);
  module.def("read_inputs", &read_inputs, py::arg("file"));
}

}  // namespace forefeel::python
