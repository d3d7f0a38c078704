#pragma once
// Policies, predictors and devices that are Python objects. Each call takes the interpreter's lock. An exception
// in one of their methods is kept; the session ends at its next frame, and the exception is thrown again then.

#include <pybind11/pybind11.h>

#include <atomic>
#include <exception>
#include <memory>
#include <mutex>

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel::python {

// The first exception of a session's Python parts, and the flag that ends the session.
class Failure {
 public:
  void keep(std::exception_ptr error) noexcept;
  void stop() noexcept { raised_ = true; }
  void throw_again() const;  // with the interpreter's lock
  const std::atomic<bool>& raised() const { return raised_; }

 private:
  std::mutex mutex_;
  std::exception_ptr error_;
  std::atomic<bool> raised_ = false;
};

void bind_parts(pybind11::module_& module);  // the view that a policy's method is given

// policy.prioritise(candidates, view) -> (n,) priorities. Called once per planning step, or after each dispatch
// too if the object has reads_pending = True.
std::shared_ptr<Policy> policy_of(pybind11::object policy, std::shared_ptr<Failure> failure);
// predictor.observe(t, at, velocity); predictor.predict(horizon) -> (at, deviation).
std::shared_ptr<Predictor> predictor_of(pybind11::object predictor, std::shared_ptr<Failure> failure);
// The same for registered ones, which belong to no session: an exception is thrown at once, with the text of the Python
// error.
std::unique_ptr<Policy> unique_policy_of(pybind11::object policy);
std::unique_ptr<Predictor> unique_predictor_of(pybind11::object predictor);
// device.position(t, force) -> (3,); device.duration, device.answers_force, device.force_limit if it has them.
std::shared_ptr<Device> device_of(pybind11::object device, std::shared_ptr<Failure> failure);

}  // namespace forefeel::python
