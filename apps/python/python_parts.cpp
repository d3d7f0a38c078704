#include "apps/python/python_parts.hpp"

#include <fmt/format.h>

#include <unordered_map>

#include "apps/python/arrays.hpp"
#include "apps/python/space.hpp"
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
  void look(const PlannerView&) override { known_.clear(); }
  void pend(const PlannerView&) override {
    if (reads_pending_) known_.clear();
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
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const auto found = known_.find(candidates[i].at);
      if (found == known_.end())
        asked.push_back(i);
      else
        out[i] = found->second;
    }
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
  struct Hash {
    std::size_t operator()(const Vec3& at) const {
      std::size_t hash = 0;
      for (int i = 0; i < 3; ++i) hash = hash * 1000003 + std::hash<double>()(at[i]);
      return hash;
    }
  };

  void ask(std::span<const Candidate> candidates, const std::vector<std::size_t>& asked,
           const PlannerView& view, std::span<double> out) const {
    const py::gil_scoped_acquire locked;
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
      known_[candidates[asked[k]].at] = value;
    }
  }

  Held object_;
  std::shared_ptr<Failure> failure_;
  std::string name_;
  bool reads_regions_ = false, reads_pending_ = false;
  mutable std::unordered_map<Vec3, double, Hash> known_;  // in this planning step
};

class PythonPredictor final : public Predictor {
 public:
  PythonPredictor(py::object object, std::shared_ptr<Failure> failure)
      : object_(std::move(object)), failure_(std::move(failure)) {}

  void observe(const HipSample& sample) override {
    last_ = sample;
    if (failure_->raised()) return;
    try {
      const py::gil_scoped_acquire locked;
      const Vec3 values[] = {sample.at, sample.velocity};
      const py::array_t<double> both = array_of(values);
      (*object_).attr("observe")(sample.t, both[py::int_(0)], both[py::int_(1)]);
    } catch (...) {
      failure_->keep(std::current_exception());
    }
  }
  Prediction predict(double horizon) const override {
    Prediction out{.horizon = horizon, .at = last_.at, .deviation = 0};
    if (failure_->raised()) return out;
    try {
      const py::gil_scoped_acquire locked;
      const auto given = py::cast<py::tuple>((*object_).attr("predict")(horizon));
      if (given.size() != 2) throw InputError("predictor", "predict() must return (at, deviation)");
      out.at = vector_of(given[0], "predictor.predict()");
      out.deviation = py::cast<double>(given[1]);
    } catch (...) {
      failure_->keep(std::current_exception());
    }
    return out;
  }

 private:
  Held object_;
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
      const py::gil_scoped_acquire locked;
      const py::array_t<double> given = array_of(std::span(&force, 1));
      last_ = vector_of((*object_).attr("position")(t, given[py::int_(0)]), "device.position()");
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
std::shared_ptr<Device> device_of(py::object device, std::shared_ptr<Failure> failure) {
  return std::make_shared<PythonDevice>(std::move(device), std::move(failure));
}

void bind_parts(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(CandidateRow, at, region, requested, delta, order, passing);
  PYBIND11_NUMPY_DTYPE(PredictionRow, horizon, at, deviation);
  module.attr("candidate_dtype") = py::dtype::of<CandidateRow>();
  using View = PlannerViewForPython;
  py::class_<View, std::shared_ptr<View>>(module, "PlannerView")
      .def_property_readonly("now", [](const View& self) { return (*self).now; })
      .def_property_readonly(
          "hip", [](const View& self) { return array_of(std::span(&(*self).hip.at, 1))[py::int_(0)]; })
      .def_property_readonly(
          "velocity",
          [](const View& self) { return array_of(std::span(&(*self).hip.velocity, 1))[py::int_(0)]; })
      .def_property_readonly("predicted",
                             [](const View& self) {
                               const auto predicted = (*self).predicted;
                               py::array_t<PredictionRow> rows(static_cast<py::ssize_t>(predicted.size()));
                               PredictionRow* row = rows.mutable_data();
                               for (const Prediction& p : predicted)
                                 *row++ = {p.horizon, {p.at[0], p.at[1], p.at[2]}, p.deviation};
                               return rows;
                             })
      .def_property_readonly("solve_seconds", [](const View& self) { return (*self).solve_seconds; })
      .def_property_readonly("workers", [](const View& self) { return (*self).workers; })
      .def_property_readonly("pending", [](const View& self) { return array_of((*self).pending); })
      .def_property_readonly("spacing", [](const View& self) { return (*self).space.options().spacing; })
      .def_property_readonly("space", [](const View& self) {
        // Shared without ownership: it is the planner's, and valid as long as the view.
        return PySpace{std::shared_ptr<const StateSpace>(std::shared_ptr<void>(), &(*self).space)};
      });
}

}  // namespace forefeel::python
