#include "apps/session/shape_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/picture/base64.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_shapes = 60, most_values = 150'000;  // of all shapes: some 400 kB of text

// Triangles from behind to the front, each in one colour: grey at rest, red where it moved most.
constexpr std::string_view script = R"JS(
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('shape-data').textContent);
  const unpacked = (text, Type) => new Type(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
  const rest = unpacked(data.rest, Int16Array), moved = unpacked(data.moved, Int16Array);
  const corners = unpacked(data.triangles, Uint32Array), n = rest.length / 3, faces = corners.length / 3;
  const canvas = document.getElementById('shape-view'), clock = document.getElementById('shape-clock');
  const now = document.getElementById('shape-now');
  let azimuth = data.azimuth, elevation = data.elevation;
  const at = new Float32Array(3 * n), seen = new Float32Array(3 * n), depth = new Float32Array(faces);
  const order = Array.from({length: faces}, (_, i) => i);

  function place(k) {
    for (let i = 0; i < 3 * n; ++i) at[i] = data.rest_scale * rest[i] + data.moved_scale * moved[3 * n * k + i];
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
    for (let i = 0; i < n; ++i) {
      const x = at[3 * i], y = at[3 * i + 1], z = at[3 * i + 2], out = ca * x + sa * y;
      seen[3 * i] = ca * y - sa * x;
      seen[3 * i + 1] = ce * z - se * out;
      seen[3 * i + 2] = ce * out + se * z;
    }
  }
  function colour(face, k) {
    let share = 0;
    for (let c = 0; c < 3; ++c) {
      const i = 3 * n * k + 3 * corners[3 * face + c];
      share += Math.hypot(moved[i], moved[i + 1], moved[i + 2]) * data.moved_scale / data.largest / 3;
    }
    const [a, b, c] = [0, 1, 2].map(j => 3 * corners[3 * face + j]);
    const u = [0, 1, 2].map(j => seen[b + j] - seen[a + j]), v = [0, 1, 2].map(j => seen[c + j] - seen[a + j]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const light = 0.6 + 0.4 * Math.abs(normal[2]) / (Math.hypot(...normal) || 1);
    return 'rgb(' + [[205, 192], [212, 57], [218, 43]].map(
        ([from, to]) => Math.round(light * (from + (to - from) * Math.min(1, share)))).join() + ')';
  }
  function draw() {
    const k = Number(clock.value), scale = window.devicePixelRatio || 1;
    const w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = Math.round(w * scale);
    canvas.height = Math.round(h * scale);
    const pen = canvas.getContext('2d'), zoom = scale * Math.min(w, h) / data.size;
    place(k);
    for (let f = 0; f < faces; ++f)
      depth[f] = seen[3 * corners[3 * f] + 2] + seen[3 * corners[3 * f + 1] + 2] + seen[3 * corners[3 * f + 2] + 2];
    order.sort((a, b) => depth[a] - depth[b]);
    for (const f of order) {
      pen.beginPath();
      for (let c = 0; c < 3; ++c) {
        const i = 3 * corners[3 * f + c];
        pen.lineTo(canvas.width / 2 + zoom * seen[i], canvas.height / 2 - zoom * seen[i + 1]);
      }
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = colour(f, k);
      pen.fill();
      pen.stroke();
    }
    now.textContent = data.t[k].toFixed(3) + ' s, moved by up to ' + (1e3 * data.most[k]).toPrecision(3) + ' mm';
  }
  canvas.addEventListener('pointerdown', e => canvas.setPointerCapture(e.pointerId));
  canvas.addEventListener('pointermove', e => {
    if (!e.buttons) return;
    azimuth -= 0.01 * e.movementX;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + 0.01 * e.movementY));
    draw();
  });
  clock.addEventListener('input', draw);
  window.addEventListener('resize', draw);
  draw();
})();
)JS";

// Values as whole multiples of `scale`, so that two bytes hold each.
std::string packed(const std::vector<double>& values, double& scale) {
  double most = 1e-12;
  for (const double value : values) most = std::max(most, std::abs(value));
  scale = most / 32000;
  std::vector<std::int16_t> whole;
  for (const double value : values) whole.push_back(static_cast<std::int16_t>(std::lround(value / scale)));
  return base64(whole);
}

struct Surface {
  std::vector<std::size_t> place;  // of each node of the surface among the log's nodes
  std::vector<std::uint32_t> corners;
  std::vector<double> rest;  // about the middle of the body [m]
  double size = 0;           // diameter of what is shown [m]
};

Surface surface_of(const ShapeLog& log) {
  Surface s;
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
  Vec3 contact = Vec3::Zero();
  for (const NodeIndex node : body.contact) contact += body.mesh.nodes[node];
  const Vec3 out = contact / static_cast<double>(body.contact.size()) - bounding_box(body.mesh).centre();
  const double azimuth = std::hypot(out[0], out[1]) > 1e-3 * out.norm() ? std::atan2(out[1], out[0]) : -1.0;
  const double elevation = out.norm() > 0 ? std::asin(std::clamp(out[2] / out.norm(), -1.0, 1.0)) : 0;
  return {azimuth + 0.5, std::clamp(elevation, 0.3, 0.7)};
}

std::size_t shown_of(const ShapeLog& log) {
  return std::min({log.records().size(), most_shapes, most_values / (3 * log.nodes().size()) + 2});
}

std::string data_of(const ShapeLog& log) {
  const Surface surface = surface_of(log);
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
  const std::string rest = packed(surface.rest, rest_scale), all = packed(moved, moved_scale);
  const auto [azimuth, elevation] = view_of(log);
  return fmt::format(
      "{{\"t\":[{}],\"most\":[{}],\"largest\":{},\"size\":{},\"azimuth\":{},\"elevation\":{},\"rest_scale\":{"
      "},"
      "\"moved_scale\":{},\"rest\":\"{}\",\"moved\":\"{}\",\"triangles\":\"{}\"}}",
      times, most, largest, surface.size, azimuth, elevation, rest_scale, moved_scale, rest, all,
      base64(surface.corners));
}

std::string percent_of_size(double share) {
  return std::isfinite(share) ? fmt::format("{:.2g} %", 100 * share) : "–";
}

}  // namespace

std::string shape_view(const ShapeLog& log, const ShapeSummary& s) {
  if (log.records().empty()) return "<h2>Shape of the body</h2>\n<p class=\"note\">No shape was made.</p>\n";
  const std::size_t last = shown_of(log) - 1;
  return fmt::format(
             "<h2>Shape of the body ({} shapes at {:g} Hz)</h2>\n<p>The worst node is off by {} (median) and "
             "{} (95th "
             "percentile) of the largest displacement in {} shapes compared with tight solves.</p>\n<figure>"
             "<canvas id=\"shape-view\" role=\"img\" aria-label=\"the body's surface\" "
             "style=\"width:100%;height:360px;touch-action:none;cursor:grab\"></canvas>\n"
             "<input id=\"shape-clock\" type=\"range\" min=\"0\" max=\"{}\" value=\"{}\" style=\"width:70%\" "
             "aria-label=\"time\"> <span id=\"shape-now\"></span><figcaption>Drag to turn. Grey: at rest, "
             "red: moved "
             "most. All shapes are in shape.pvd, for ParaView.</figcaption></figure>\n",
             s.shapes, s.rate, percent_of_size(s.error.p50), percent_of_size(s.error.p95), s.error.samples,
             last, last / 2) +
         "<script type=\"application/json\" id=\"shape-data\">" + data_of(log) + "</script>\n<script>" +
         std::string(script) + "</script>\n";
}

}  // namespace forefeel
