#include "approx/methods/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "approx/error/error_bar.hpp"
#include "approx/error/leave_one_out.hpp"
#include "approx/error/left_out.hpp"
#include "approx/error/place_models.hpp"
#include "approx/methods/evaluate_points.hpp"
#include "approx/methods/point_runs.hpp"
#include "approx/methods/rbf_network.hpp"
#include "approx/model/model_options.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/index/point_octree.hpp"
#include "geometry/states/heaps.hpp"
#include "geometry/states/misleading.hpp"

namespace forefeel {
namespace {

constexpr double one_position = 1e-6;     // of the extent of measured states
constexpr double most_apart = 20;         // bars inside the states: the widest over the narrowest
constexpr double most_apart_between = 5;  // of places where the states know all directions

// One model of all states is made of forces alone unless data is given.
ModelOptions model_options(const EvaluateOptions& options, bool stiffness, std::size_t states) {
  return wished_model(options.model, stiffness && options.method != Method::offline_rbf, states);
}

// Refuses a model that does not fit into memory, as a session does.
void check_memory(const ModelOptions& options, std::size_t states) {
  try {
    for_states(options, states);
  } catch (const InputError& error) {
    throw InputError("--neighbours", error.problem());
  }
}

bool is_chosen(const EvaluateOptions& o, bool stiffness) {
  const bool open = !o.method && !o.model.kernel && !o.model.data && !o.model.neighbours && !o.model.ridge &&
                    !o.choose_ridge;
  return o.choose.value_or(open && !stiffness);
}

// A process has none of these. Without bars there is then no use for one.
bool may_be_process(const ModelWishes& wishes) {
  return !wishes.kernel && !wishes.neighbours && !wishes.select && !wishes.ridge;
}

StateSpace space_of(std::span<const State> states, double spacing) {
  StateSpace space({.spacing = spacing > 0 ? spacing : StateSpaceOptions{}.spacing});
  for (const State& state : states) space.insert(state);
  return space;
}

// Longest side of the box of the states, of which there is at least one [m].
double extent_of(std::span<const State> states) {
  Box box{states.front().at, states.front().at};
  for (const State& s : states) box = {box.low.cwiseMin(s.at), box.high.cwiseMax(s.at)};
  return box.size().maxCoeff();
}

// Rows within a millionth of the extent of all are one position: no hand and no encoder tells them apart.
void join_near(std::vector<State>& states) {
  const double apart = one_position * extent_of(states);
  if (!(apart > 0)) return;
  PointOctree joined;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const PointOctree::Neighbour known = joined.nearest(states[i].at, apart);
    if (known.id == PointOctree::nobody)
      joined.insert(static_cast<std::uint32_t>(i), states[i].at);
    else
      states[i].at = states[known.id].at;
  }
}

// A row far from all others, as of a tracker that was lost, says nothing about them, yet a law of the field would reach
// as far. It stays where a point is asked that is nearest to it.
bool leave_far_row_out(std::vector<State>& states, std::span<const Vec3> points) {
  const std::optional<std::size_t> row = far_row(states);
  if (!row || points.empty()) return false;
  const Vec3& far = states[*row].at;
  const auto nearest_to_it = [&](const Vec3& x) {
    return std::ranges::none_of(states, [&](const State& s) {
      return s.at != far && (s.at - x).squaredNorm() < (far - x).squaredNorm();
    });
  };
  if (std::ranges::any_of(points, nearest_to_it)) return false;
  states.erase(states.begin() + static_cast<std::ptrdiff_t>(*row));
  return true;
}

// One state at each position: the same row twice adds no knowledge, and a held-out force must have no twin that stays.
std::vector<State> distinct(const StateSpace& space) {
  std::vector<State> states;
  states.reserve(space.size());
  for (std::uint32_t id = 0; id < space.size(); ++id) states.push_back(space[StateId{id}]);
  return states;
}

// The points, moved onto the states where these do not know the direction across them (measured/force_field.hpp).
std::vector<Vec3> feet(std::span<const Vec3> points, const JudgedPoints& judged) {
  std::vector<Vec3> at(points.begin(), points.end());
  for (std::size_t i = 0; i < judged.at.size(); ++i) at[i] = judged.at[i].foot;
  return at;
}

// What no force left out shows: across the states the error to expect is at least S E, as seldom as 5 % m S E; and the
// error that rows share.
void raise(AutoModel& chosen, const JudgedPoints& judged, double shared) {
  std::vector<double> across, seldom;
  for (const ForceField::Prediction& made : judged.at) {
    BarWidths widths{};
    widen(widths, made.least_error);
    across.push_back(made.least_error);
    seldom.push_back(widths[1]);
  }
  if (across.empty() || !std::isfinite(chosen.p95)) return;
  const double least = quantile_of(seldom, 0.95);
  chosen.across = least > chosen.p95;
  chosen.p50 = std::max(chosen.p50, quantile_of(across, 0.5)) + shared;
  chosen.p95 = std::max(chosen.p95, least) + shared;
}

// Adds the error that rows share. No force is larger than `bound`, so no error is larger than that and the model's.
void bound_bars(EvaluatedBars& bars, std::span<const Vec3> forces, double shared, double bound) {
  for (std::size_t i = 0; i < bars.at.size(); ++i)
    for (double& width : bars.at[i])
      if (std::isfinite(width)) width = std::min(width + shared, bound + forces[i].norm());
}

std::vector<SeenPlace> seen_from(const StateSpace& space, std::span<const Vec3> points) {
  const PlaceLocator locate(space);
  std::vector<SeenPlace> seen(points.size());
  for_each_run(points, [&](PointRun run, std::size_t) {
    for (const std::uint32_t i : run) seen[i] = locate(points[i]);
  });
  return seen;
}

// A model of the neighbours of each point, or one of all states.
EvaluatedPoints moving_points(const StateSpace& space, std::span<const Vec3> points,
                              std::span<const Vec3> places, const ModelOptions& model, bool all,
                              const ShowShare& show) {
  const PointModels models{
      .maker = [&] { return models_of(space, model, false); }, .places = places, .options = &model};
  if (!all) return points_of_models(models, space, points, show);
  return points_of_one_model(*models_of(space, model, true), models, space, points, show);
}

// An older method: one approximation of all states.
EvaluatedPoints fixed_points(const StateSpace& space, std::span<const Vec3> points,
                             std::span<const Vec3> places, const Evaluation& how,
                             std::span<const State> states, const ShowShare& show) {
  OneModel maker([&] { return std::make_unique<const Approximation>(how.method, states, how.options); });
  return points_of_one_model(maker, {.maker = {}, .places = places}, space, points, show);
}

ShowShare stage_of(const EvaluateOptions& options, std::string_view what) {
  if (!options.show) return {};
  return [show = options.show, what](double share) { show(what, share); };
}

void begin_stage(const EvaluateOptions& options, std::string_view what) {
  if (options.show) options.show(what, unknown);
}

EvaluatedBars bars_of(const StateSpace& space, std::span<const State> states, std::span<const Vec3> points,
                      const EvaluatedPoints& made, const JudgedPoints& judged,
                      const OfflineBarOptions& options, const EvaluateOptions& given) {
  const auto checked = [&](const Vec3& x) { return given.checks.box.contains(x); };
  OfflineBars measured = checked_bars(space, given.checks.states, options), left_out;
  if (!measured.checked())
    measured = measure_bars(states, options);
  else if (!std::ranges::all_of(points, checked))
    left_out = measure_bars(states, options);
  const OfflineBars& own = measured.checked() ? left_out : measured;
  EvaluatedBars bars;
  std::vector<SeenPlace> unchecked, held;
  std::vector<char> inside, between;
  for (const BarSample& s : own.samples()) held.push_back(s.seen);
  const auto bar = [&](std::size_t i) {
    if (measured.checked() && checked(points[i]))
      return measured.at({.label = made.labels[i], .scale = checked_scale(made.forces[i])});
    return own.at({.x = points[i],
                   .label = made.labels[i],
                   .outside = options.wanted[i].outside,
                   .scale = options.judge ? judged.at[i].scale_of(made.forces[i])
                                          : scale_at(space, points[i], made.forces[i]),
                   .across = judged.at.empty() ? 0 : judged.at[i].least_error});
  };
  bars.at.resize(points.size());
  for_each_run(points, [&](PointRun run, std::size_t) {
    for (const std::uint32_t i : run) bars.at[i] = bar(i);
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (measured.checked() && checked(points[i])) continue;
    unchecked.push_back(options.wanted[i]);
    bars.outside += unchecked.back().outside ? 1 : 0;
  }
  if (!judged.at.empty() && options.judge && !measured.checked()) {
    for (std::size_t i = 0; i < unchecked.size(); ++i) {
      inside.push_back(unchecked[i].outside ? 0 : 1);
      between.push_back(inside.back() && judged.at[i].least_error == 0 ? 1 : 0);
    }
    keep_together(bars.at, inside, most_apart);
    keep_together(bars.at, between, most_apart_between);
  }
  bars.beyond = count_beyond(held, unchecked);
  bars.measured = std::make_shared<const OfflineBars>(std::move(measured));
  return bars;
}

}  // namespace

Evaluation evaluate(std::span<const State> states, std::span<const Vec3> points,
                    const EvaluateOptions& options) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw InputError("points", fmt::format("row {} (from 0) is not finite, expected three numbers", i));
  std::vector<State> usable;
  usable.reserve(states.size());
  std::ranges::copy_if(states, std::back_inserter(usable), &State::usable);
  if (usable.empty()) throw InputError("states", "none is solved or measured, expected at least one");
  const bool stiffness = std::ranges::any_of(usable, &State::has_stiffness);
  Evaluation result{.method = options.method.value_or(Method::rbf)};
  ModelOptions& model = result.options.model = model_options(options, stiffness, usable.size());
  if (model.data == Data::force_and_stiffness && !stiffness)
    throw InputError("states", "no state has a stiffness, expected columns k11 to k33 or --data force");
  if (model.data == Data::jet &&
      std::ranges::none_of(usable, [](const State& s) { return s.jet != nullptr; }))
    throw InputError("states", "no state has an energy jet, expected columns e300 to e005, or other --data");
  const std::size_t rows = usable.size();
  if (!stiffness) {
    result.far_row_left_out = leave_far_row_out(usable, points);
    join_near(usable);
    JoinedHeaps joined = join_heaps(std::move(usable));
    usable = std::move(joined.states);
    result.heaped = joined.rows;
  }
  AveragedStates mean = averaged(std::move(usable));
  result.repeated = mean.found;
  const double spacing = options.spacing > 0 ? options.spacing : estimate_spacing(mean.states);
  const StateSpace all = space_of(mean.states, spacing);
  if (all.size() < mean.states.size()) mean.states = distinct(all);
  result.states = all.size();
  // Wider heaps: the process has all their rows; what counts rows, or takes the nearest ones, has few.
  const std::vector<State> even = stiffness ? mean.states : thinned_heaps(mean.states);
  std::optional<StateSpace> thinned;
  if (even.size() < mean.states.size()) thinned = space_of(even, spacing);
  const StateSpace& space = thinned ? *thinned : all;
  result.options.spacing = space.options().spacing;
  const bool moving = result.method == Method::rbf;
  if (const auto off = options.noise.position; off && !(*off < extent_of(mean.states)))
    throw InputError("--position-noise",
                     fmt::format("is {:g} m, as large as all the states, expected less", *off));
  const bool open = moving && is_chosen(options, stiffness);
  const auto stage = [&](std::string_view what) { return stage_of(options, what); };
  std::vector<SeenPlace> wanted;
  if (open || (moving && options.bars)) wanted = seen_from(space, points);
  if (moving && !stiffness && ((open && may_be_process(options.model)) || options.bars)) {
    begin_stage(options, "the law of the measured field");
    result.field = options.field ? options.field : field_of(mean.states, options.noise);
  }
  if (result.field) {
    result.shared = shared_error(states, result.repeated, result.field->law.noise);
    result.field->stated = options.stiffest.has_value();
    if (options.stiffest) result.field->stiffest = *options.stiffest / across_of_95;
  }
  const JudgedPoints judged =
      judge_points(all, points, result.field, stage("the measured field at the points"));
  for (std::size_t i = 0; i < judged.at.size(); ++i) wanted[i].doubt = judged.at[i].own_deviation;
  if (open) {
    begin_stage(options, "choosing a model");
    result.chosen = choose_model(even,
                                 {.field = result.field,
                                  .model = options.model,
                                  .spacing = result.options.spacing,
                                  .progress = stage("choosing a model")},
                                 wanted);
    raise(*result.chosen, judged, result.shared.sum());
    model = result.chosen->model;
  }
  if (result.method == Method::rbf && !(result.chosen && result.chosen->field))
    check_memory(model, space.size());
  model.neighbours = std::min(model.neighbours, space.size());
  if (options.choose_ridge) model.ridge = forefeel::choose_ridge(space, model).ridge;
  const std::vector<Vec3> places = feet(points, open ? judged : JudgedPoints{});
  if (result.method == Method::rbf_network)
    result.options.centres = RbfNetwork::centres_of(rows, options.model.neighbours.value_or(0));
  const std::optional<FieldOptions> process = result.chosen ? result.chosen->field : std::nullopt;
  const bool own = process && !same_process(*process, *result.field);
  const bool local = process && process->local;  // it judges itself
  const JudgedPoints near =
      own ? judge_points(all, points, process, stage("the field at the points")) : JudgedPoints{};
  const JudgedPoints& made_by = own ? near : judged;
  result.made = process  ? points_of_process(made_by, name(process->law.smoothness), space, points)
                : moving ? moving_points(space, points, places, model, result.chosen && result.chosen->all,
                                         stage("points"))
                         : fixed_points(space, points, places, result, even, stage("points"));
  if (moving && options.bars) begin_stage(options, "error bars");
  if (moving && options.bars)
    result.bars = bars_of(space, even, points, result.made, local ? near : judged,
                          {.model = model,
                           .all = result.chosen && result.chosen->all,
                           .field = process,
                           .judge = local           ? process
                                    : result.chosen ? result.field
                                                    : std::nullopt,
                           .spacing = result.options.spacing,
                           .wanted = wanted,
                           .show = stage("error bars")},
                          options);
  if (result.bars && result.field)
    bound_bars(*result.bars, result.made.forces, result.shared.sum(),
               options.stiffest ? std::numeric_limits<double>::infinity() : judged.bound);
  result.fit_us = median(result.made.fit_us);
  result.evaluate_ns = median(result.made.evaluate_ns);
  return result;
}

std::vector<State> measured_states(std::span<const Vec3> positions, std::span<const Vec3> forces,
                                   std::span<const Mat3> stiffness) {
  if (forces.size() != positions.size() || (!stiffness.empty() && stiffness.size() != positions.size()))
    throw InputError("states",
                     fmt::format("{} positions, {} forces and {} stiffnesses, expected one of each for "
                                 "every state (or no stiffness)",
                                 positions.size(), forces.size(), stiffness.size()));
  std::vector<State> states(positions.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    states[i].at = positions[i];
    states[i].force = forces[i];
    if (!stiffness.empty()) states[i].stiffness = stiffness[i];
    if (!states[i].at.allFinite() || !states[i].force.allFinite())
      throw InputError("states", fmt::format("state {} is not finite, expected finite numbers", i));
  }
  return states;
}

}  // namespace forefeel
