#include "approx/methods/evaluate_points.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "approx/methods/point_runs.hpp"
#include "geometry/coverage/place_walk.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_timed = 1000;  // points at which a force is timed, about

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Its evaluation is repeated so that the clock resolves its time.
double evaluation_ns(const ForceModel& model, const Place& place) {
  constexpr int repeats = 16;
  Vec3 sum = Vec3::Zero();
  const auto begin = Clock::now();
  for (int r = 0; r < repeats; ++r) sum += model.force(place);
  return sum.allFinite() ? 1e9 * since(begin) / repeats : unknown;
}

// A model that exists, for all places.
class GivenModel final : public ForceMaker {
 public:
  explicit GivenModel(const ForceModel& model) : model_(model) {}
  const ForceModel& at(const Place&, UpdateReport* report) override {
    *report = {};
    return model_;
  }

 private:
  const ForceModel& model_;
};

// What one run of points took.
struct RunTimes {
  std::vector<double> fit_us = {}, evaluate_ns = {};
  std::size_t fitted = 0, updated = 0, reused = 0;
};

}  // namespace

JudgedPoints judge_points(const StateSpace& space, std::span<const Vec3> points,
                          const std::optional<FieldOptions>& options, const ShowShare& show) {
  JudgedPoints judged;
  if (!options) return judged;
  const auto start = Clock::now();
  const ForceField field(space, *options);
  judged.fit_us = 1e6 * since(start);
  judged.bound = field.bound();
  judged.at.resize(points.size());
  judged.evaluate_ns.resize(points.size());
  const auto work = [&](PointRun run, std::size_t) {
    for (const std::uint32_t i : run) {
      const auto begin = Clock::now();
      judged.at[i] = field.at(points[i]);
      judged.evaluate_ns[i] = 1e9 * since(begin);
    }
  };
  for_each_run(points, work, show);
  return judged;
}

EvaluatedPoints points_of_process(const JudgedPoints& judged, std::string_view kernel,
                                  const StateSpace& space, std::span<const Vec3> points) {
  EvaluatedPoints result;
  result.fitted = std::min<std::size_t>(points.size(), 1);
  result.reused = points.size() - result.fitted;
  result.labels.resize(points.size());
  const auto work = [&](PointRun run, std::size_t) {
    PlaceWalk walk;
    for (const std::uint32_t i : run) result.labels[i] = walk.label(space, points[i]);
  };
  for_each_run(points, work);
  for (const ForceField::Prediction& made : judged.at) result.forces.push_back(made.force);
  result.reach.assign(points.size(), {.bound = judged.bound});
  result.kernels.assign(points.size(), kernel);
  result.fit_us = {judged.fit_us};
  result.evaluate_ns = judged.evaluate_ns;
  return result;
}

EvaluatedPoints points_of_models(const PointModels& models, const StateSpace& space,
                                 std::span<const Vec3> points, const ShowShare& show) {
  const std::size_t count = points.size(), stride = 1 + count / most_timed;
  EvaluatedPoints result;
  result.forces.resize(count);
  result.labels.resize(count);
  result.reach.resize(count);
  result.kernels.resize(count);
  if (models.options && models.options->data == Data::jet) result.trusted.resize(count);
  std::vector<RunTimes> took(count_runs(count));
  const auto work = [&](PointRun run, std::size_t number) {
    const std::unique_ptr<ForceMaker> maker = models.maker();
    RunTimes& mine = took[number];
    PlaceWalk walk;
    for (const std::uint32_t i : run) {
      const Place place{models.places[i]};
      UpdateReport report;
      const auto start = Clock::now();
      const ForceModel& model = maker->at(place, &report);
      const double seconds = since(start);
      const bool changed = report.refit || report.replaced > 0;
      if (changed) mine.fit_us.push_back(1e6 * seconds);
      ++(report.refit ? mine.fitted : changed ? mine.updated : mine.reused);
      const Answer answer = model.at(place);
      result.forces[i] = answer.force;
      result.labels[i] = walk.label(space, points[i]);
      result.reach[i] = answer.reach;
      result.kernels[i] = answer.kernel;
      if (!result.trusted.empty()) result.trusted[i] = answer.trusted ? 1 : 0;
      if (i % stride == 0) mine.evaluate_ns.push_back(evaluation_ns(model, place));
    }
  };
  for_each_run(points, work, show);
  for (const RunTimes& run : took) {
    result.fitted += run.fitted, result.updated += run.updated, result.reused += run.reused;
    result.fit_us.insert(result.fit_us.end(), run.fit_us.begin(), run.fit_us.end());
    result.evaluate_ns.insert(result.evaluate_ns.end(), run.evaluate_ns.begin(), run.evaluate_ns.end());
  }
  const ModelOptions* options = models.options;
  for (const std::string_view kernel : result.kernels)
    if (options && !kernel.empty() && kernel != "jets" && kernel != name(options->kernel))
      ++result.stepped_down;
  std::erase(result.kernels, std::string_view());
  return result;
}

EvaluatedPoints points_of_one_model(ForceMaker& of_all, const PointModels& models, const StateSpace& space,
                                    std::span<const Vec3> points, const ShowShare& show) {
  if (points.empty()) return {};
  UpdateReport report;
  const auto start = Clock::now();
  const ForceModel& model = of_all.at({models.places.front()}, &report);
  const double fit_us = 1e6 * since(start);
  PointModels given = models;
  given.maker = [&] { return std::make_unique<GivenModel>(model); };
  EvaluatedPoints result = points_of_models(given, space, points, show);
  result.fit_us = {fit_us};
  result.fitted = 1, --result.reused;
  return result;
}

}  // namespace forefeel
