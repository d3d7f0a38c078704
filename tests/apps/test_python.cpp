// The Python package forefeel: the numbers of the command, parts written in Python, examples.

#include "tests/support/executable.hpp"

namespace {

fs::path package() {
  return build_folder() / "apps" / "python";
}

bool is_missing() {
  if (!fs::exists(package() / "forefeel" / "__init__.py")) {
    skip("the Python module is not built: pybind11 is not installed");
    return true;
  }
  if (has_python_module("scipy")) return false;
  skip("python3-scipy is not installed");
  return true;
}

// Runs a script below the sources with the package of this build.
Workshop::Outcome python(const Workshop& shop, const std::string& script, const std::string& arguments) {
  return shop.shell("MPLCONFIGDIR=. PYTHONPATH='" + package().string() + "' /usr/bin/python3 '" +
                    (source_folder() / script).string() + "' " + arguments);
}

double number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  INFO(text);
  REQUIRE(at != std::string::npos);
  return std::stod(text.substr(at + words.size()));
}

void run_checks(const std::string& script) {
  if (is_missing()) return;
  const Workshop shop;
  const auto scene = shop.write("beam.toml", beam_scene());
  const Workshop::Outcome done = python(shop, script, "'" + executable() + "' '" + scene.string() + "'");
  INFO(done.err);
  CHECK(done.code == 0);
}

}  // namespace

TEST_CASE("the Python package gives the command's numbers and runs parts written in Python",
          SLOW("runs the Python module, which only run.sh all builds")) {
  run_checks("tests/apps/python_module.py");
}

TEST_CASE("bodies, files, interruption, errors and documentation of the Python package",
          SLOW("runs the Python module, which only run.sh all builds")) {
  run_checks("tests/apps/python_package.py");
}

TEST_CASE("masks, floats as numbers, masked and complex arrays and positions without forces in Python",
          SLOW("runs the Python module, which only run.sh all builds")) {
  run_checks("tests/apps/python_input.py");
}

TEST_CASE("a Python body with a pad has the forces of the command, and wrong pads are refused",
          SLOW("runs the Python module, which only run.sh all builds")) {
  run_checks("tests/apps/python_pads.py");
}

TEST_CASE("the Python example of the paper's figure finds blank space worse than sparse",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  if (!has_python_module("matplotlib")) return skip("python3-matplotlib is not installed");
  const Workshop shop;
  const auto scene = shop.write("beam.toml", beam_scene());
  const Workshop::Outcome done = python(shop, "apps/examples/fig2.py", "'" + scene.string() + "' fig2.png");
  INFO(done.err);
  REQUIRE(done.code == 0);
  CHECK(number_after(done.out, "blank: error") > 5 * number_after(done.out, "sparse: error"));
  CHECK(fs::file_size(shop.path() / "fig2.png") > 10'000);
}

TEST_CASE("the Python example of a policy compares it in a study, and its policy wins",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  const Workshop shop;
  const fs::path scene = source_folder() / "apps/scenes/paper.toml";
  const Workshop::Outcome done = python(shop, "apps/examples/own_policy.py", "'" + scene.string() + "' own");
  INFO(done.err);
  REQUIRE(done.code == 0);
  CHECK(number_after(done.out, "nearest:") < 60);
  CHECK(number_after(done.out, "ahead:") > number_after(done.out, "nearest:") + 10);
}

TEST_CASE("the Python examples of a predictor and of a sampler compare theirs in a study",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const Workshop::Outcome predictor = python(shop, "apps/examples/own_predictor.py", "beam.toml own");
  INFO(predictor.err);
  REQUIRE(predictor.code == 0);
  CHECK_THAT(predictor.out,
             Contains("kalman: 95 % within", "slowing: 95 % within", "slowing:tau=0.1: 95 % within"));
  const Workshop::Outcome sampler = python(shop, "apps/examples/own_sampler.py", "beam.toml sampled");
  INFO(sampler.err);
  REQUIRE(sampler.code == 0);
  CHECK(number_after(sampler.out, "halton:") > 0);
  CHECK(number_after(sampler.out, "list:places.csv:") > 0);
}

TEST_CASE("the notebooks run, and what they show is so",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  if (!has_python_module("matplotlib") || !has_python_module("pandas"))
    return skip("python3-matplotlib or python3-pandas is not installed");
  const Workshop shop;
  const auto run = [&](const std::string& name) {
    const fs::path file = source_folder() / "apps/examples" / name;
    const Workshop::Outcome done = python(shop, "tests/apps/run_notebook.py", "'" + file.string() + "'");
    INFO(name << done.err);
    REQUIRE(done.code == 0);
    CHECK(number_after(done.out, "cells:") >= 2);
    return done.out;
  };
  const std::string schedulers = run("compare_schedulers.ipynb");
  CHECK(number_after(schedulers, "coverage") > number_after(schedulers, "nearest") + 5);
  const std::string points = run("classify_points.ipynb");
  CHECK(number_after(points, "safe") > 0.8 * 4 * M_PI / 3);  // of the ball [m^3]
  CHECK(number_after(run("touch_your_organ.ipynb"), "error of the force:") < 7);
}

TEST_CASE("a script that registers a policy, which nothing else holds, ends with exit code 0",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  const Workshop shop;
  shop.write("short.py",
             "import forefeel as ff\n"
             "class Policy:\n"
             "    def prioritise(self, candidates, view): return 1 / (1 + candidates['delta'])\n"
             "ff.register_policy('brief', lambda **settings: Policy())\n"
             "print('registered')\n");
  const Workshop::Outcome done = python(shop, (shop.path() / "short.py").string(), "");
  INFO(done.err);
  CHECK(done.code == 0);
  CHECK(done.out == "registered\n");
}

TEST_CASE("the Python example of ask and tell learns a solver of SciPy to 2 % with 40 states",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  const Workshop shop;
  const Workshop::Outcome done = python(shop, "apps/examples/ask_and_tell.py", "");
  INFO(done.err);
  REQUIRE(done.code == 0);
  CHECK(done.out.starts_with("40 states"));
  CHECK(number_after(done.out, "median ") < 2);
}

TEST_CASE("the Python example of ask and tell learns hyperelastic solves of FEniCSx",
          SLOW("runs the Python module, which only run.sh all builds")) {
  if (is_missing()) return;
  if (!has_python_module("dolfinx")) return skip("python3-dolfinx is not installed");
  const Workshop shop;
  const Workshop::Outcome done = python(shop, "apps/examples/ask_and_tell_fenicsx.py", "");
  INFO(done.err);
  REQUIRE(done.code == 0);
  CHECK_THAT(done.out, Catch::StartsWith("24 states of FEniCSx"));
  CHECK(number_after(done.out, "median ") < 2);
  CHECK(number_after(done.out, "largest ") < 7);  // the JND
}
