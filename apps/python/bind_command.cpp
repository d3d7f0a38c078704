#include <pybind11/stl.h>
#include <signal.h>

#include <array>
#include <string>
#include <vector>

#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/main/program.hpp"
#include "apps/python/bindings.hpp"
#include "apps/python/python_parts.hpp"

namespace forefeel::python {

namespace py = pybind11;
namespace {

// Saves and restores Python's signal handlers, because a command installs its own and ends with the system's.
class KeptSignals {
 public:
  KeptSignals() {
    for (std::size_t i = 0; i < numbers.size(); ++i) sigaction(numbers[i], nullptr, &kept_[i]);
  }
  ~KeptSignals() {
    for (std::size_t i = 0; i < numbers.size(); ++i) sigaction(numbers[i], &kept_[i], nullptr);
  }
  KeptSignals(const KeptSignals&) = delete;
  KeptSignals& operator=(const KeptSignals&) = delete;

 private:
  static constexpr std::array numbers{SIGINT, SIGTERM, SIGHUP, SIGALRM, SIGPIPE, SIGXFSZ};
  std::array<struct sigaction, numbers.size()> kept_{};
};

// The exit code of `forefeel WORDS`. Its errors are exceptions.
int run_command(const std::vector<std::string>& words) {
  const py::gil_scoped_release released;
  const KeptSignals kept;
  std::vector<const char*> argv{"forefeel"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  try {
    return run_program(forefeel_program(), static_cast<int>(argv.size()), argv.data());
  } catch (const Interrupted&) {
    return 1;
  }
}

// factory(**settings) makes a part for each session; settings are texts, as after the name in a study.
py::object made_by(const py::handle& factory, FactoryContext& with) {
  py::dict settings;
  for (const std::string& key : with.arguments.keys()) settings[py::str(key)] = with.arguments.text(key, "");
  return factory(**settings);
}

// The tables of parts outlive the interpreter, so they borrow the factory; a list of the module owns it.
void add_policy(const std::string& name, const py::function& factory, py::list& owned) {
  owned.append(factory);
  forefeel::register_policy(name, [borrowed = py::handle(factory)](FactoryContext& with) {
    const py::gil_scoped_acquire locked;
    return unique_policy_of(made_by(borrowed, with));
  });
}
void add_predictor(const std::string& name, const py::function& factory, py::list& owned) {
  owned.append(factory);
  forefeel::register_predictor(name, [borrowed = py::handle(factory)](FactoryContext& with) {
    const py::gil_scoped_acquire locked;
    return unique_predictor_of(made_by(borrowed, with));
  });
}

}  // namespace

void bind_command(py::module_& module) {
  module.def("_command", &run_command, py::arg("words"));
  py::list owned;
  module.attr("_factories") = owned;
  module.def(
      "register_policy",
      [owned](const std::string& name, const py::function& factory) mutable {
        add_policy(name, factory, owned);
      },
      py::arg("name"), py::arg("factory"),
      "Makes a policy known by a name, in studies and sessions of this process. factory(**settings) "
      "returns an "
      "object with the method prioritise(candidates, view); settings are texts.");
  module.def(
      "register_predictor",
      [owned](const std::string& name, const py::function& factory) mutable {
        add_predictor(name, factory, owned);
      },
      py::arg("name"), py::arg("factory"),
      "The same for predictors: objects with observe(t, at, velocity) and predict(horizon) -> (at, "
      "deviation).");
  module.attr("version") = py::str(version_text());
}

}  // namespace forefeel::python
