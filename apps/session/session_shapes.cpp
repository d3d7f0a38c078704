#include "apps/session/session_shapes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/console/summary_json.hpp"
#include "apps/session/shape_view.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/record/shape_files.hpp"

namespace forefeel {

ShapeOptions shape_options(const Scene& scene, const SessionArguments& given) {
  ShapeOptions options = scene.shape;
  if (!given.shape_rate) return options;
  options.rate = *given.shape_rate;
  if (!(options.rate >= 0 && options.rate <= 200))
    throw InputError("--shape-rate", fmt::format("is {}, expected 0 to 200 Hz", options.rate));
  return options;
}

SessionShapes::SessionShapes(const ShapeOptions& options, const SessionPlan& plan,
                             const SessionArguments& given) {
  if (!(options.rate > 0)) return;
  if (plan.input.touched.anywhere)
    throw InputError(given.shape_rate ? "--shape-rate" : "session.shape_rate",
                     "is of one place, expected none with contact.anywhere");
  if (plan.input.foreign)
    throw InputError("--foreign",
                     "renders states of another body, whose shape is not known; expected a session "
                     "without shapes (session.shape_rate = 0)");
  check_shapeable(plan.input.known, *plan.input.touched.body, given.states.file);
  run_.emplace(ShapedRun{.log = std::make_shared<ShapeLog>(plan.input.touched.body, options)});
}

std::vector<std::string> SessionShapes::files() const {
  if (!run_) return {};
  return {"shape.pvd", "shape.csv"};
}

void SessionShapes::begin_files(const std::filesystem::path& run) {
  if (!run_) return;
  series_ = std::async(std::launch::async, [log = run_->log, run] { write_shape_series(run, *log); });
}

std::shared_future<std::string> SessionShapes::begin_picture() const {
  if (!run_) return {};
  return std::async(std::launch::async,
                    [log = run_->log, summary = summarise(*run_->log, run_->checked)] {
                      return shape_view(*log, summary);
                    })
      .share();
}

void SessionShapes::finish_files(const std::filesystem::path& run) {
  if (!run_) return;
  series_.get();
  write_shape_table(run, *run_->log, run_->checked);
}

void SessionShapes::add_to(nlohmann::ordered_json& document) const {
  if (run_) document["shape"] = to_json(shape_columns(summarise(*run_->log, run_->checked)));
}

std::optional<std::string> SessionShapes::in_words() const {
  if (!run_) return {};
  const ShapeSummary s = summarise(*run_->log, run_->checked);
  const auto percent = [](double share) {
    return std::isfinite(share) ? fmt::format("{:.2g} %", 100 * share) : "unknown";
  };
  return fmt::format(
      "{} shapes at {:g} Hz of {} nodes{}; largest error of a node, of the largest displacement: p50 "
      "{}, p95 {} of {} compared",
      s.shapes, s.rate, s.nodes, s.missed > 0 ? fmt::format(", {} instants missed", s.missed) : "",
      percent(s.error.p50), percent(s.error.p95), s.error.samples);
}

}  // namespace forefeel
