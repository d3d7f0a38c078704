#include "apps/session/run_data.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "apps/console/json_text.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"
#include "geometry/common/base64.hpp"
#include "scheduling/record/summary.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;
using Frames = std::span<const FrameRecord>;

constexpr std::size_t most_frames = 60'000;

// Four digits are enough for a picture.
Json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0.0;
  const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 4);
  return std::round(value / step) * step;
}

Json moment(double t) {  // to 0.1 ms
  return std::round(1e4 * t) / 1e4;
}

// One column behind the other: time, |rendered|, |sent|, |newest model|, x, y, z, 95 % error bar (-1: none).
std::string columns_of(Frames frames, std::size_t every) {
  std::vector<float> values;
  const auto add = [&](auto value) {
    for (std::size_t i = 0; i < frames.size(); i += every) {
      const double v = value(frames[i]);
      values.push_back(std::isfinite(v) ? static_cast<float>(v) : 0.0f);
    }
  };
  add([](const FrameRecord& f) { return f.t; });
  add([](const FrameRecord& f) { return f.force.norm(); });
  add([](const FrameRecord& f) { return f.sent.norm(); });
  add([](const FrameRecord& f) { return f.undamped.norm(); });
  for (int axis = 0; axis < 3; ++axis) add([axis](const FrameRecord& f) { return f.at[axis]; });
  add([](const FrameRecord& f) {
    const double bar = f.bar.half_width[1];
    return std::isfinite(bar) ? bar : -1.0;
  });
  return base64(values);
}

// [time, value] where the value changes.
template <class Value>
Json changes(Frames frames, Value value) {
  Json list = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (i == 0 || value(frames[i]) != value(frames[i - 1]))
      list.push_back({moment(frames[i].t), value(frames[i])});
  return list;
}

// [begin, end] of the times in which the rendered force is above the limit.
Json clamped(Frames frames, double limit) {
  Json list = Json::array();
  if (!std::isfinite(limit)) return list;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i;
    while (end < frames.size() && frames[end].force.norm() > limit * (1 + 1e-6)) ++end;
    if (end > i)
      list.push_back({moment(frames[i].t), moment(end < frames.size() ? frames[end].t : frames.back().t)});
    i = std::max(end, i + 1);
  }
  return list;
}

// [t, |reference|, error, error in JNDs, its three parts, first visit, x, y, z]
Json samples(Frames frames, const RunView& view) {
  Json list = Json::array();
  for (const FrameRecord& f : frames) {
    const Judgement& j = f.judged;
    if (!std::isfinite(j.error)) continue;
    Json row{moment(f.t), rounded(j.reference.norm()), rounded(j.error), rounded(times_jnd(f, view))};
    for (const double part : {j.approximation, j.switching, j.staleness}) row.push_back(rounded(part));
    row.push_back(j.first_visit ? 1 : 0);
    for (const double x : f.at) row.push_back(rounded(x));
    list.push_back(std::move(row));
  }
  return list;
}

Json switches(std::span<const SwitchRecord> all) {
  Json list = Json::array();
  for (const SwitchRecord& s : all)
    list.push_back(
        {moment(s.t), s.model, name(s.cause), name(s.label), s.n, s.replaced, rounded(s.jump_undamped)});
  return list;
}

Json corners(const Vec3& low, const Vec3& high) {
  return Json::array({Json::array({low[0], low[1], low[2]}), Json::array({high[0], high[1], high[2]})});
}

// Colours by what the script calls them.
Json inks() {
  Json out{{"newest", ink("undamped")}, {"reference", ink("reference_light")}};
  for (const char* meaning : {"rendered", "sent", "limit", "approximation", "switching", "staleness", "bar",
                              "within", "above", "far_above"})
    out[meaning] = ink(meaning);
  return out;
}

}  // namespace

std::string run_data(const SessionResult& result, const RunView& view) {
  const Frames frames = result.frames;
  const std::size_t every = frames.size() / most_frames + 1;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  for (const FrameRecord& f : frames) {
    low = low.cwiseMin(f.at);
    high = high.cwiseMax(f.at);
  }
  Json document{{"frames", (frames.size() + every - 1) / every},
                {"end", frames.empty() ? 0.0 : frames.back().t},
                {"limit", rounded(view.force_limit)},
                {"box", corners(view.box.low, view.box.high)},
                {"reach", corners(low, high)},
                {"ink", inks()}};
  for (const Label label : all_labels) {
    document["names"].push_back(name(label));
    document["colours"].push_back(colour(label));
  }
  document["labels"] = changes(frames, [](const FrameRecord& f) { return static_cast<int>(f.label); });
  document["known"] = changes(frames, [](const FrameRecord& f) { return f.known; });
  document["models"] = changes(frames, [](const FrameRecord& f) { return f.step.model; });
  document["clamped"] = clamped(frames, view.force_limit);
  document["samples"] = samples(frames, view);
  document["switches"] = switches(result.switches);
  document["columns"] = columns_of(frames, every);
  return json_text(document);
}

}  // namespace forefeel
