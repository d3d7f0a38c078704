#include "apps/show/show_page.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "apps/console/json.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/palette.hpp"
#include "geometry/common/base64.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

// {"f32": "base64"}, which the script turns into a typed array.
template <class T>
Json packed(const char* type, const std::vector<T>& values) {
  return {{type, base64(values)}};
}

// Values of a list as one array of floats; value(item) is a double or a Vec3.
template <class Items, class Value>
Json floats(const Items& items, Value&& value) {
  std::vector<float> all;
  for (const auto& item : items) {
    if constexpr (requires { double(value(item)); }) {
      all.push_back(static_cast<float>(value(item)));
    } else {
      const Vec3 v = value(item);
      for (int k = 0; k < 3; ++k) all.push_back(static_cast<float>(v[k]));
    }
  }
  return packed("f32", all);
}

template <class Items, class Value>
Json packed_bytes(const Items& items, Value&& value) {
  std::vector<std::uint8_t> all;
  for (const auto& item : items) all.push_back(static_cast<std::uint8_t>(value(item)));
  return packed("u8", all);
}

template <class Items, class Value>
Json packed_counts(const Items& items, Value&& value) {
  std::vector<std::uint32_t> all;
  for (const auto& item : items) all.push_back(static_cast<std::uint32_t>(value(item)));
  return packed("u32", all);
}

Json box_json(const Box& box) {
  return {{"low", vector3(box.low)}, {"high", vector3(box.high)}};
}

Json corners_of(const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> corners;
  for (const Triangle& t : triangles) corners.insert(corners.end(), t.begin(), t.end());
  return packed("u32", corners);
}

Json pad_json(const ShownPad& pad) {
  return {{"shade", name(pad.shade)},
          {"depth", pad.depth},
          {"least", pad.least},
          {"peak", pad.peak},
          {"facet", packed("u32", pad.facet)},
          {"at", floats(pad.at, [](const Vec3& at) { return at; })},
          {"weight", floats(pad.weight, [](double weight) { return weight; })},
          {"triangles", corners_of(pad.triangles)}};
}

Json body_json(const ShownBody& body) {
  Json out;
  out["nodes"] = floats(body.nodes, [](const Vec3& p) { return p; });
  out["triangles"] = corners_of(body.triangles);
  out["role"] = packed_bytes(body.role, [](Role role) { return role; });
  out["node"] = packed_counts(body.node, [](NodeIndex node) { return node; });
  out["groups"] = Json::array();
  for (const ShownGroup& group : body.groups)
    out["groups"].push_back({{"name", group.name}, {"nodes", packed("u32", group.nodes)}});
  out["regions"] = Json::array();
  for (std::size_t i = 0; i < body.regions.all.size(); ++i)
    out["regions"].push_back({{"name", body.regions.all[i].name},
                              {"words", body.regions.all[i].words},
                              {"volume", body.regions.all[i].volume},
                              {"colour", colour_of(palette_in_use(), i)}});
  out["rest_words"] = body.regions.rest_words;
  out["region"] = packed_bytes(body.regions.of_triangle, [](std::uint8_t region) { return region; });
  out["inside"] = {
      {"nodes", floats(body.regions.inside.nodes, [](const Vec3& p) { return p; })},
      {"triangles", corners_of(body.regions.inside.triangles)},
      {"region", packed_bytes(body.regions.inside.region, [](std::uint8_t region) { return region; })}};
  out["pad"] = body.pad ? pad_json(*body.pad) : Json();
  out["rest"] = vector3(body.rest);
  out["elements"] = body.mesh.tets.size();
  return out;
}

// Runs of equal labels: label, length (two bytes, low first).
Json grid_json(const LabelGrid& grid) {
  std::vector<std::uint8_t> runs;
  for (std::size_t begin = 0; begin < grid.label.size();) {
    std::size_t end = begin + 1;
    while (end < grid.label.size() && end - begin < 65535 && grid.label[end] == grid.label[begin]) ++end;
    runs.push_back(static_cast<std::uint8_t>(grid.label[begin]));
    runs.push_back(static_cast<std::uint8_t>((end - begin) & 255));
    runs.push_back(static_cast<std::uint8_t>((end - begin) >> 8));
    begin = end;
  }
  return {{"time", grid.time}, {"count", grid.count}, {"runs", packed("u8", runs)}};
}

Json states_json(const ShownStates& states) {
  Json out;
  out["at"] = floats(states.all, [](const ShownState& s) { return s.state.at; });
  out["force"] = floats(states.all, [](const ShownState& s) { return s.state.force; });
  out["label"] = packed_bytes(states.all, [](const ShownState& s) { return s.label; });
  out["outcome"] = packed_bytes(states.all, [](const ShownState& s) { return outcome(s.state); });
  out["known"] = floats(states.all, [](const ShownState& s) { return s.known; });
  for (const SolveStatus status : {SolveStatus::converged, SolveStatus::diverged, SolveStatus::stalled,
                                   SolveStatus::inverted, SolveStatus::cancelled, SolveStatus::measured})
    out["outcomes"].push_back(std::string(name(status)));
  out["volume"] = states.regions.volume.values;
  out["components"] = states.regions.component_count.values;
  out["labels"] = Json::array();
  for (const LabelGrid& grid : states.labels) out["labels"].push_back(grid_json(grid));
  return out;
}

Json shapes_json(const std::vector<ShownShape>& shapes) {
  std::vector<double> all;
  for (const ShownShape& shape : shapes)
    for (const Vec3& moved : shape.moved) all.insert(all.end(), moved.begin(), moved.end());
  double scale = 0;
  const std::string packed = base64_of_whole(all, scale);
  return {{"t", floats(shapes, [](const ShownShape& s) { return s.t; })},
          {"scale", scale},
          {"moved", {{"i16", packed}}}};
}

Json run_json(const ShownRun& run) {
  Json out;
  out["t"] = floats(run.path, [](const ShownFrame& f) { return f.t; });
  out["at"] = floats(run.path, [](const ShownFrame& f) { return f.at; });
  out["sent"] = floats(run.path, [](const ShownFrame& f) { return f.sent; });
  out["label"] = packed_bytes(run.path, [](const ShownFrame& f) { return f.label; });
  out["error"] = floats(run.path, [](const ShownFrame& f) { return f.error; });
  if (std::ranges::any_of(run.path, &ShownFrame::trusted))  // else the models are not of jets
    out["trusted"] = packed_bytes(run.path, [](const ShownFrame& f) { return f.trusted; });
  out["known"] = packed_counts(run.path, [](const ShownFrame& f) { return f.known; });
  out["frames"] = run.frames;
  out["shapes"] = run.shapes.empty() ? Json() : shapes_json(run.shapes);
  return out;
}

// "<" is written as an escape, so that no text ends the script that holds the data.
std::string data_text(const ShowContent& content) {
  Json out{{"kind", content.kind}, {"title", content.title}};
  out["spacing"] = number(content.spacing);
  out["box"] = content.box ? box_json(*content.box) : Json();
  out["extent"] = box_json(extent_of(content));
  const ViewPoint view = view_of(content);
  out["view"] = {view.azimuth, view.elevation};
  out["colours"] = Json::object();
  for (const char* meaning :
       {"axis_x", "axis_y", "axis_z", "blank", "blank_dot", "body", "clamp", "contact", "failed", "force",
        "gap", "group", "path", "path_light", "ramp_high", "ramp_low", "safe", "solved", "sparse"})
    out["colours"][meaning] = ink(meaning);
  out["body"] = content.body ? body_json(*content.body) : Json();
  out["states"] = content.states ? states_json(*content.states) : Json();
  out["run"] = content.run ? run_json(*content.run) : Json();
  std::string safe;
  for (const char c : json_text(out))
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  return safe;
}

// Embedded at build time, or as Debian's libjs-three installs it.
std::string library(std::string_view embedded, const char* installed, const std::string& file) {
  if (!embedded.empty()) return std::string(embedded);
  std::ifstream in(std::filesystem::path("/usr/share/javascript/three") / installed, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || text.str().empty())
    throw InputError(
        {.file = file},
        "needs three.js, which this forefeel was built without and which is not installed; expected "
        "the package libjs-three (apt-get install libjs-three), or an output .vtu");
  return text.str();
}

// Forbids the page to load anything; the browser enforces it.
constexpr std::string_view policy =
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:\">\n";

}  // namespace

std::string show_page(const ShowContent& content, const std::string& file) {
  const std::string three = library(three_script, "three.min.js", file);
  const std::string orbit = library(orbit_script, "examples/js/controls/OrbitControls.js", file);
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n";
  page += policy;
  page += "<title>" + html_escaped(content.title) + "</title>\n<style>\n";
  page += viewer_style;
  page += "</style></head><body>\n";
  page += viewer_body;
  page += three_licence;
  const auto script = [&](std::string_view text) {
    page += "<script>\n";
    page += text;
    page += "\n</script>\n";
  };
  script(three);
  script(orbit);
  page += "<script id=\"data\" type=\"application/json\">" + data_text(content) + "</script>\n";
  script(viewer_script);
  return page + "</body></html>\n";
}

}  // namespace forefeel
