#pragma once
// The points of evaluate(): forces, labels and judgements there, by all threads (point_runs.hpp). Each depends on its
// point alone; the numbers of models made and kept depend on the runs, not on the threads.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "approx/measured/force_field.hpp"
#include "approx/model/force_makers.hpp"
#include "approx/model/force_model.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

// Called by one thread with the share done.
using ShowShare = std::function<void(double)>;

// What the process of measured states gives at the points, and what it took.
struct JudgedPoints {
  std::vector<ForceField::Prediction> at;  // empty: no process
  double fit_us = unknown, bound = unknown;
  std::vector<double> evaluate_ns = {};
};

// Nothing without options.
JudgedPoints judge_points(const StateSpace& space, std::span<const Vec3> points,
                          const std::optional<FieldOptions>& options, const ShowShare& show);

// How models are made: each run of points has a maker of its own.
struct PointModels {
  std::function<std::unique_ptr<ForceMaker>()> maker;
  std::span<const Vec3> places;           // of the points, as the models are asked
  const ModelOptions* options = nullptr;  // of RBF models; null: others
};

EvaluatedPoints points_of_models(const PointModels& models, const StateSpace& space,
                                 std::span<const Vec3> points, const ShowShare& show);
// With the one model that of_all makes.
EvaluatedPoints points_of_one_model(ForceMaker& of_all, const PointModels& models, const StateSpace& space,
                                    std::span<const Vec3> points, const ShowShare& show);
// With the forces of the process that judged the points. kernel: its name.
EvaluatedPoints points_of_process(const JudgedPoints& judged, std::string_view kernel,
                                  const StateSpace& space, std::span<const Vec3> points);

}  // namespace forefeel
