#include "apps/session/session_shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "apps/console/summary_json.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/palette.hpp"
#include "geometry/common/base64.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/record/shape_files.hpp"

namespace forefeel {

namespace {

constexpr std::size_t drawn_shapes = 60, drawn_values = 150'000;  // of all shapes: some 400 kB of text

struct ShownSurface {
  std::vector<std::size_t> place;  // of each node of the surface among the log's nodes
  std::vector<std::uint32_t> corners;
  std::vector<double> rest;  // about the middle of the body [m]
  double size = 0;           // diameter of what is shown [m]
};

ShownSurface surface_of(const ShapeLog& log) {
  ShownSurface s;
  const TetMesh& mesh = log.body().mesh;
  const Box box = bounding_box(mesh);
  const std::vector<NodeIndex> nodes = surface_nodes(mesh);
  for (const NodeIndex node : nodes) {
    s.place.push_back(
        static_cast<std::size_t>(std::ranges::lower_bound(log.nodes(), node) - log.nodes().begin()));
    const Vec3 at = mesh.nodes[node] - box.centre();
    s.rest.insert(s.rest.end(), {at[0], at[1], at[2]});
  }
  for (const Triangle& triangle : boundary_triangles(mesh))
    for (const NodeIndex node : triangle)
      s.corners.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(nodes, node) - nodes.begin()));
  s.size = box.size().norm();
  return s;
}

// From where the contact is in sight, in radians.
std::pair<double, double> view_of(const ShapeLog& log) {
  const Body& body = log.body();
  const Vec3 out = rest_of_contact(body) - bounding_box(body.mesh).centre();
  const double azimuth = std::hypot(out[0], out[1]) > 1e-3 * out.norm() ? std::atan2(out[1], out[0]) : -1.0;
  const double elevation = out.norm() > 0 ? std::asin(std::clamp(out[2] / out.norm(), -1.0, 1.0)) : 0;
  return {azimuth + 0.5, std::clamp(elevation, 0.3, 0.7)};
}

std::size_t shown_of(const ShapeLog& log) {
  return std::min({log.records().size(), drawn_shapes, drawn_values / (3 * log.nodes().size()) + 2});
}

std::string data_of(const ShapeLog& log) {
  const ShownSurface surface = surface_of(log);
  const std::size_t shapes = log.records().size();
  const std::size_t count = shown_of(log);
  std::vector<double> moved;
  std::vector<float> u;
  std::string times, most;
  double largest = 1e-9;
  for (std::size_t i = 0; i < count; ++i) {
    const ShapeRecord& record = log.records()[count > 1 ? i * (shapes - 1) / (count - 1) : 0];
    log.displacements(record, u);
    for (const std::size_t place : surface.place)
      for (std::size_t c = 0; c < 3; ++c) moved.push_back(u[3 * place + c]);
    times += fmt::format("{}{}", i > 0 ? "," : "", record.t);
    most += fmt::format("{}{:.6g}", i > 0 ? "," : "", record.largest);
    largest = std::max(largest, record.largest);
  }
  double rest_scale = 0, moved_scale = 0;
  const std::string rest = base64_of_whole(surface.rest, rest_scale),
                    all = base64_of_whole(moved, moved_scale);
  const auto [azimuth, elevation] = view_of(log);
  return fmt::format(
      "{{\"colours\":[\"{}\",\"{}\"],\"t\":[{}],\"most\":[{}],\"largest\":{},\"size\":{},\"azimuth\":{},"
      "\"elevation\":{},\"rest_scale\":{"
      "},"
      "\"moved_scale\":{},\"rest\":\"{}\",\"moved\":\"{}\",\"triangles\":\"{}\"}}",
      ink("at_rest"), ink("moved"), times, most, largest, surface.size, azimuth, elevation, rest_scale,
      moved_scale, rest, all, base64(surface.corners));
}

std::string percent_of_size(double share) {
  return std::isfinite(share) ? in_percent(share) : "–";
}

}  // namespace

std::string shape_view(const ShapeLog& log, const ShapeSummary& s) {
  if (log.records().empty()) return "<h2>Shape of the body</h2>\n<p class=\"note\">No shape was made.</p>\n";
  const std::size_t last = shown_of(log) - 1;
  return fmt::format(
             "<h2>Shape of the body ({} at {:g} Hz)</h2>\n<p>The worst node is off by {} (median) and "
             "{} (95th "
             "percentile) of the largest displacement in {} compared with tight solves.</p>\n<figure>"
             "<canvas id=\"shape-view\" role=\"img\" aria-label=\"the body's surface\" "
             "style=\"width:100%;height:360px;touch-action:none;cursor:grab\"></canvas>\n"
             "<input id=\"shape-clock\" type=\"range\" min=\"0\" max=\"{}\" value=\"{}\" style=\"width:70%\" "
             "aria-label=\"time\"> <span id=\"shape-now\"></span><figcaption>Drag to turn. Grey: at rest, "
             "{}: moved "
             "most. All shapes are in shape.pvd, for ParaView.</figcaption></figure>\n",
             counted(s.shapes, "shape"), s.rate, percent_of_size(s.error.p50), percent_of_size(s.error.p95),
             counted(s.error.samples, "shape"), last, last / 2,
             palette_in_use() == palette_from_text(std::string(usual_palette)) ? "red" : "dark") +
         "<script type=\"application/json\" id=\"shape-data\">" + data_of(log) + "</script>\n<script>\n" +
         std::string(shape_script) + "</script>\n";
}

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
  if (plan.input.foreign)
    throw InputError("--foreign",
                     "renders states of another body, whose shape is not known; expected a session "
                     "without shapes (session.shape_rate = 0)");
  check_shapeable(plan.input.known, *plan.input.touched.body, given.states.file);
  const TouchedBody& touched = plan.input.touched;
  run_.emplace(
      ShapedRun{.log = std::make_shared<ShapeLog>(touched.body, options, EachShape(), sites_of(touched))});
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
  const auto or_unknown = [](double share) { return std::isfinite(share) ? in_percent(share) : "unknown"; };
  return fmt::format(
      "{} at {:g} Hz of {}{}; largest error of a node, of the largest displacement: p50 "
      "{}, p95 {} of {} compared",
      counted(s.shapes, "shape"), s.rate, counted(s.nodes, "node"),
      s.missed > 0 ? ", " + counted(s.missed, "instant") + " missed" : "", or_unknown(s.error.p50),
      or_unknown(s.error.p95), s.error.samples);
}

}  // namespace forefeel
