#include "apps/python/python_parts.hpp"

#include <fmt/format.h>

#include <vector>

#include "apps/python/arrays.hpp"
#include "apps/python/scene_object.hpp"
#include "apps/scene/spec_text.hpp"
#include "geometry/common/error.hpp"

namespace forefeel::python {

void Failure::keep(std::exception_ptr error) noexcept {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = std::move(error);
  raised_ = true;
}

void Failure::throw_again() const {
  if (error_) std::rethrow_exception(error_);
}

namespace {

struct CandidateRow {
  double at[3];
  std::uint8_t region;  // label
  double requested, delta;
  std::uint32_t order;
  bool passing;
};

struct PredictionRow {
  double horizon, at[3], deviation;
};

// Keeps the interpreter's record of this thread, if it is one that Python did not start. Otherwise each lock would make
// a record and throw it away, which takes longer than a short call.
class PythonThread {
 public:
  PythonThread() {
    if (PyGILState_GetThisThreadState() != nullptr) return;
    ensured_ = PyGILState_Ensure();
    saved_ = PyEval_SaveThread();
  }
  ~PythonThread() {
    if (saved_ == nullptr || Py_IsInitialized() == 0) return;
    PyEval_RestoreThread(saved_);
    PyGILState_Release(ensured_);
  }
  PythonThread(const PythonThread&) = delete;
  PythonThread& operator=(const PythonThread&) = delete;

 private:
  PyGILState_STATE ensured_{};
  PyThreadState* saved_ = nullptr;
};

// The interpreter's lock, taken in each call of a part.
class Locked {
 private:
  static const PythonThread& of_this_thread() {
    static thread_local const PythonThread thread;
    return thread;
  }
  const PythonThread& thread_ = of_this_thread();  // before the lock
  const py::gil_scoped_acquire lock_;
};

// A Python object whose last reference may be dropped on any thread.
class Held {
 public:
  explicit Held(py::object object) : object_(std::move(object)) {}
  ~Held() {
    const py::gil_scoped_acquire locked;
    object_ = py::object();
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  const py::object& operator*() const { return object_; }

 private:
  py::object object_;
};

Vec3 vector_of(const py::handle& value, const char* what) {
  const std::vector<Vec3> one = points_of(py::cast<Doubles>(value), what);
  if (one.size() != 1) throw InputError(what, "expected three numbers");
  return one.front();
}

struct PlannerViewForPython {
  const PlannerView* view = nullptr;  // null once the call is over

  const PlannerView& operator*() const {
    if (view == nullptr) throw std::runtime_error("a planner's view is valid only during prioritise()");
    return *view;
  }
};

class PythonPolicy final : public Policy {
 public:
  PythonPolicy(py::object object, std::shared_ptr<Failure> failure)
      : object_(std::move(object)), failure_(std::move(failure)) {
    const py::object& policy = *object_;
    name_ = py::hasattr(policy, "name") ? py::cast<std::string>(policy.attr("name"))
                                        : py::cast<std::string>(py::type::of(policy).attr("__name__"));
    const auto flag = [&](const char* key, bool otherwise) {
      return py::hasattr(policy, key) ? py::cast<bool>(policy.attr(key)) : otherwise;
    };
    reads_regions_ = flag("reads_regions", false);
    reads_pending_ = flag("reads_pending", false);
    if (!py::hasattr(policy, "prioritise"))
      throw InputError("policy", "has no method prioritise(candidates, view)");
  }

  std::string_view name() const override { return name_; }
  bool reads_regions() const override { return reads_regions_; }
  void look(const PlannerView&) override { ++step_; }
  void pend(const PlannerView&) override {
    if (reads_pending_) ++step_;
  }
  // Without reads_pending a priority does not change within a step.
  double at_most(double priority) const override {
    return reads_pending_ ? std::numeric_limits<double>::infinity() : priority;
  }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    double one = 0;
    prioritise({&candidate, 1}, view, {&one, 1});
    return one;
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                  std::span<double> out) const override {
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (!is_known(candidates[i], out[i])) asked.push_back(i);
    if (asked.empty()) return;
    for (const std::size_t i : asked) out[i] = 0;
    if (failure_ && failure_->raised()) return;
    try {
      ask(candidates, asked, view, out);
    } catch (const std::exception& error) {
      if (!failure_) throw std::runtime_error(name_ + ": " + error.what());
      failure_->keep(std::current_exception());
    }
  }

 private:
  // What the object gave a candidate in a planning step, by Candidate::order.
  struct Given {
    std::uint64_t step = 0;
    Vec3 at = Vec3::Zero();
    double value = 0;
  };
  bool is_known(const Candidate& candidate, double& value) const {
    if (candidate.order >= given_.size()) return false;
    const Given& given = given_[candidate.order];
    value = given.value;
    return given.step == step_ && given.at == candidate.at;
  }
  void remember(const Candidate& candidate, double value) const {
    constexpr std::uint32_t most = 10'000'000;
    if (candidate.order >= most) return;
    if (candidate.order >= given_.size()) given_.resize(candidate.order + 1000);
    given_[candidate.order] = {step_, candidate.at, value};
  }

  void ask(std::span<const Candidate> candidates, const std::vector<std::size_t>& asked,
           const PlannerView& view, std::span<double> out) const {
    const Locked locked;
    py::array_t<CandidateRow> rows(static_cast<py::ssize_t>(asked.size()));
    CandidateRow* row = rows.mutable_data();
    for (const std::size_t i : asked) {
      const Candidate& c = candidates[i];
      *row++ = {.at = {c.at[0], c.at[1], c.at[2]},
                .region = static_cast<std::uint8_t>(c.region),
                .requested = c.requested,
                .delta = c.delta,
                .order = c.order,
                .passing = c.passing};
    }
    const auto shown = std::make_shared<PlannerViewForPython>(PlannerViewForPython{&view});
    const auto given = py::cast<Doubles>((*object_).attr("prioritise")(rows, shown));
    shown->view = nullptr;
    if (given.size() != rows.size())
      throw InputError(
          "policy", fmt::format("prioritise() gave {} values for {} candidates", given.size(), rows.size()));
    for (std::size_t k = 0; k < asked.size(); ++k) {
      const double value = given.data()[k];
      if (!(value >= 0) || !std::isfinite(value))
        throw InputError("policy", fmt::format("prioritise() gave {}, expected finite numbers >= 0", value));
      out[asked[k]] = value;
      remember(candidates[asked[k]], value);
    }
  }

  Held object_;
  std::shared_ptr<Failure> failure_;
  std::string name_;
  bool reads_regions_ = false, reads_pending_ = false;
  std::uint64_t step_ = 1;  // grows when what was given holds no more
  mutable std::vector<Given> given_;
};

class PythonPredictor final : public Predictor {
 public:
  // Without a failure, exceptions are thrown on.
  PythonPredictor(py::object object, std::shared_ptr<Failure> failure)
      : observe_(object.attr("observe")), predict_(object.attr("predict")), failure_(std::move(failure)) {}

  void observe(const HipSample& sample) override {
    last_ = sample;
    if (failure_ && failure_->raised()) return;
    try {
      const Locked locked;
      (*observe_)(sample.t, array_of(sample.at), array_of(sample.velocity));
    } catch (const std::exception& error) {
      if (!failure_) throw std::runtime_error(fmt::format("predictor: {}", error.what()));
      failure_->keep(std::current_exception());
    }
  }
  Prediction predict(double horizon) const override {
    Prediction out{.horizon = horizon, .at = last_.at, .deviation = 0};
    if (failure_ && failure_->raised()) return out;
    try {
      const Locked locked;
      const auto given = py::cast<py::tuple>((*predict_)(horizon));
      if (given.size() != 2) throw InputError("predictor", "predict() must return (at, deviation)");
      out.at = vector_of(given[0], "predictor.predict()");
      out.deviation = py::cast<double>(given[1]);
    } catch (const std::exception& error) {
      if (!failure_) throw std::runtime_error(fmt::format("predictor: {}", error.what()));
      failure_->keep(std::current_exception());
    }
    return out;
  }

 private:
  Held observe_, predict_;
  std::shared_ptr<Failure> failure_;
  HipSample last_;
};

class PythonDevice final : public Device {
 public:
  PythonDevice(py::object object, std::shared_ptr<Failure> failure)
      : object_(std::move(object)), failure_(std::move(failure)) {
    const py::object& device = *object_;
    if (!py::hasattr(device, "position")) throw InputError("device", "has no method position(t, force)");
    if (py::hasattr(device, "duration")) duration_ = py::cast<double>(device.attr("duration"));
    if (py::hasattr(device, "answers_force")) answers_force_ = py::cast<bool>(device.attr("answers_force"));
    if (py::hasattr(device, "force_limit")) limits_.force = py::cast<double>(device.attr("force_limit"));
  }

  Vec3 position(double t, const Vec3& force) noexcept override {
    if (failure_->raised()) return last_;
    try {
      const Locked locked;
      last_ = vector_of((*object_).attr("position")(t, array_of(force)), "device.position()");
    } catch (...) {
      failure_->keep(std::current_exception());
    }
    return last_;
  }
  double duration() const override { return duration_; }
  bool answers_force() const override { return answers_force_; }
  DeviceLimits limits() const override { return limits_; }

 private:
  Held object_;
  std::shared_ptr<Failure> failure_;
  double duration_ = std::numeric_limits<double>::infinity();
  bool answers_force_ = false;
  DeviceLimits limits_;
  Vec3 last_ = Vec3::Zero();
};

py::array_t<PredictionRow> predictions(const PlannerViewForPython& self) {
  const auto predicted = (*self).predicted;
  py::array_t<PredictionRow> rows(static_cast<py::ssize_t>(predicted.size()));
  PredictionRow* row = rows.mutable_data();
  for (const Prediction& p : predicted) *row++ = {p.horizon, {p.at[0], p.at[1], p.at[2]}, p.deviation};
  return rows;
}

// The priorities that a built-in policy gives, made anew for this call.
py::array_t<double> built_in_priorities(const PlannerViewForPython& self, const std::string& policy,
                                        const py::array_t<CandidateRow>& rows) {
  std::vector<Candidate> candidates;
  candidates.reserve(static_cast<std::size_t>(rows.size()));
  for (const CandidateRow& row : std::span(rows.data(), static_cast<std::size_t>(rows.size())))
    candidates.push_back({.at = Vec3(row.at[0], row.at[1], row.at[2]),
                          .region = static_cast<Label>(row.region),
                          .requested = row.requested,
                          .delta = row.delta,
                          .order = row.order,
                          .passing = row.passing});
  py::array_t<double> out(rows.size());
  const std::span<double> values(out.mutable_data(), candidates.size());
  const PlannerView& view = *self;
  const std::unique_ptr<Policy> made = make_policy(part_from_text("policy", policy));
  const py::gil_scoped_release released;
  made->look(view);
  made->prioritise(candidates, view, values);
  return out;
}

}  // namespace

std::shared_ptr<Policy> policy_of(py::object policy, std::shared_ptr<Failure> failure) {
  return std::make_shared<PythonPolicy>(std::move(policy), std::move(failure));
}
std::unique_ptr<Policy> unique_policy_of(py::object policy) {
  return std::make_unique<PythonPolicy>(std::move(policy), nullptr);
}
std::shared_ptr<Predictor> predictor_of(py::object predictor, std::shared_ptr<Failure> failure) {
  return std::make_shared<PythonPredictor>(std::move(predictor), std::move(failure));
}
std::unique_ptr<Predictor> unique_predictor_of(py::object predictor) {
  return std::make_unique<PythonPredictor>(std::move(predictor), nullptr);
}
std::shared_ptr<Device> device_of(py::object device, std::shared_ptr<Failure> failure) {
  return std::make_shared<PythonDevice>(std::move(device), std::move(failure));
}

void bind_parts(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(CandidateRow, at, region, requested, delta, order, passing);
  PYBIND11_NUMPY_DTYPE(PredictionRow, horizon, at, deviation);
  module.attr("candidate_dtype") = py::dtype::of<CandidateRow>();
  using View = PlannerViewForPython;
  py::class_<View, std::shared_ptr<View>>(
      module, "PlannerView",
      "What a policy may read, and only during prioritise(). Positions count from rest [m].")
      .def_property_readonly(
          "now", [](const View& self) { return (*self).now; }, "[s]")
      .def_property_readonly(
          "hip", [](const View& self) { return array_of((*self).hip.at); }, "(3,): where the tip is [m]")
      .def_property_readonly(
          "velocity", [](const View& self) { return array_of((*self).hip.velocity); }, "(3,) [m/s]")
      .def_property_readonly(
          "predicted", &predictions,
          "Structured array, by increasing horizon, the first is now: horizon [s], at (3,) [m], "
          "deviation [m].")
      .def_property_readonly(
          "solve_seconds", [](const View& self) { return (*self).solve_seconds; },
          "Running median of a solve and its messages [s]")
      .def_property_readonly(
          "workers", [](const View& self) { return (*self).workers; }, "Number of workers")
      .def_property_readonly(
          "pending", [](const View& self) { return array_of((*self).pending); },
          "(k, 3): where states are being solved [m]")
      .def_property_readonly(
          "spacing", [](const View& self) { return (*self).space.options().spacing; },
          "Distance of states that counts as dense [m]")
      .def_property_readonly(
          "space",
          [](const View& self) {
            // Shared without ownership: it is the planner's, and valid as long as the view.
            return PySpace{std::shared_ptr<const StateSpace>(std::shared_ptr<void>(), &(*self).space)};
          },
          "The states known now; valid as long as the view.")
      .def("prioritise", &built_in_priorities, py::arg("policy"), py::arg("candidates"),
           "Priorities (n,) that a built-in policy, such as \"nearest\", gives the candidates (n,), of "
           "candidate_dtype: to mix it with one's own, or to compare.");
}

}  // namespace forefeel::python
