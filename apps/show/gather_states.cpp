#include "apps/show/gather_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/coverage/regions.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {
namespace {

constexpr double most_cells = 250'000;     // of the grid of one time
constexpr double most_of_all = 1'000'000;  // of the grids of all times

LabelGrid sample(const StateSpace& space, const Box& box, double most, double time) {
  LabelGrid grid{.time = time, .count = {1, 1, 1}, .label = {}};
  const Vec3 size = box.size().cwiseMax(1e-3 * box.size().maxCoeff());
  const double cell = std::max(space.options().spacing / 4, std::cbrt(size.prod() / most));
  Vec3 step;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double n = std::clamp(std::ceil(box.size()[axis] / cell - 1e-6), 1.0, most);
    grid.count[axis] = static_cast<std::uint32_t>(n);
    step[axis] = box.size()[axis] / n;
  }
  const std::uint32_t nx = grid.count[0], ny = grid.count[1], nz = grid.count[2];
  grid.label.resize(std::size_t{nx} * ny * nz);
#pragma omp parallel for schedule(dynamic, 1)
  for (std::uint32_t k = 0; k < nz; ++k) {
    PathWalk walk;
    for (std::uint32_t j = 0; j < ny; ++j)
      for (std::uint32_t i = 0; i < nx; ++i)
        grid.label[(std::size_t{k} * ny + j) * nx + i] =
            space.label(box.low + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)), walk);
  }
  return grid;
}

// The states known at each time, one after the other.
std::vector<LabelGrid> grids(const StateSpaceOptions& options, const std::vector<ShownState>& states,
                             std::span<const double> times) {
  std::vector<const ShownState*> order;
  for (const ShownState& s : states)
    if (s.state.usable()) order.push_back(&s);
  const auto from = [](const ShownState* s) { return std::isnan(s->known) ? -1.0 : s->known; };
  std::ranges::stable_sort(order, {}, from);
  StateSpace space(options);
  std::vector<LabelGrid> result;
  std::size_t next = 0;
  const double most = std::min(most_cells, most_of_all / double(times.size()));
  for (const double time : times) {
    for (; next < order.size() && from(order[next]) <= time; ++next) {
      State light = order[next]->state;
      light.displacements.reset();
      space.insert(std::move(light));
    }
    result.push_back(sample(space, options.box, most, time));
  }
  return result;
}

std::string as_text(const Box& box) {
  return fmt::format("{},{},{}:{},{},{}", box.low.x(), box.low.y(), box.low.z(), box.high.x(), box.high.y(),
                     box.high.z());
}

}  // namespace

void take_states(const Globals& globals, const LabelFrame& frame, std::vector<ShownState> states,
                 std::span<const double> times, ShowContent& content) {
  ClassifyArguments arguments;
  if (std::isfinite(frame.spacing)) arguments.space.spacing = frame.spacing;
  if (frame.box && frame.box->size().minCoeff() > 0) arguments.space.box = as_text(*frame.box);
  std::vector<State> usable;
  for (const ShownState& s : states)
    if (s.state.usable()) usable.push_back(s.state);
  Classified set = prepare_states(arguments, frame.where, std::move(usable), {}, globals);
  label_regions(set, arguments, {.holes = false, .leaves = true, .space = true}, globals);
  ShownStates shown;
  shown.regions = std::move(set.regions);
  for (ShownState& s : states) s.label = set.index.space->label(s.state.at);
  if (times.size() == 1)
    shown.labels.push_back(sample(*set.index.space, set.box, most_cells, times[0]));
  else
    shown.labels = grids(set.index.space->options(), states, times);
  shown.all = std::move(states);
  content.states = std::move(shown);
  content.box = set.box;
  content.spacing = set.spacing;
}

}  // namespace forefeel
