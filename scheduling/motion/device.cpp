#include "scheduling/motion/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "geometry/common/csv_table.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/motion/hand_device.hpp"
#include "scheduling/motion/path_shapes.hpp"
#include "scheduling/motion/random.hpp"

namespace forefeel {
namespace {

constexpr double two_pi = 6.283185307179586476925286766559;

// Tremor and sensor noise on top of a motion, fading in so that the path starts exactly at rest.
class Disturbance {
 public:
  Disturbance(double tremor, double noise, std::uint64_t seed) : noise_(noise), seed_(seed) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < waves; ++k) {
        const std::uint64_t key = mix(seed, 100 + static_cast<std::uint64_t>(i * waves + k));
        wave_[i][k] = {tremor * std::sqrt(2.0 / waves), two_pi * (8 + 4 * uniform(key)),
                       two_pi * uniform(mix(key, 1))};
      }
  }

  Vec3 at(double t) const noexcept {
    Vec3 sum = Vec3::Zero();
    const auto tick = static_cast<std::uint64_t>(std::llround(t * 1e6));
    for (int i = 0; i < 3; ++i) {
      for (const Wave& w : wave_[i]) sum[i] += w.amplitude * std::sin(w.frequency * t + w.phase);
      if (noise_ > 0) sum[i] += noise_ * normal(mix(mix(seed_, 7 + static_cast<std::uint64_t>(i)), tick));
    }
    return std::min(1.0, t / 0.25) * sum;
  }

 private:
  static constexpr int waves = 8;
  struct Wave {
    double amplitude, frequency, phase;  // [m], [rad/s], [rad]
  };
  Wave wave_[3][waves];
  double noise_;
  std::uint64_t seed_;
};

// A curve by arc length: lead once, loop for ever.
class Curve {
 public:
  explicit Curve(const PathShape& shape) {
    for (const Vec3& p : shape.lead) append(p);
    append(shape.loop.front());
    loop_start_ = length_.back();
    for (std::size_t i = 1; i < shape.loop.size(); ++i) append(shape.loop[i]);
    append(shape.loop.front());
  }
  double loop_start() const { return loop_start_; }
  double loop_length() const { return length_.back() - loop_start_; }

  Vec3 at(double s) const {
    if (s <= 0) return points_.front();
    if (s > length_.back()) s = loop_start_ + std::fmod(s - loop_start_, loop_length());
    const auto upper = std::upper_bound(length_.begin(), length_.end(), s);
    const auto i =
        std::min<std::size_t>(static_cast<std::size_t>(upper - length_.begin()), length_.size() - 1);
    const double span = length_[i] - length_[i - 1];
    const double w = span > 0 ? (s - length_[i - 1]) / span : 0;
    return (1 - w) * points_[i - 1] + w * points_[i];
  }

 private:
  void append(const Vec3& p) {
    length_.push_back(points_.empty() ? 0 : length_.back() + (p - points_.back()).norm());
    points_.push_back(p);
  }
  std::vector<Vec3> points_;
  std::vector<double> length_;
  double loop_start_ = 0;
};

// Means over a sliding window of given width, all at once.
std::vector<Vec3> sliding_mean(const std::vector<Vec3>& in, std::size_t window) {
  std::vector<Vec3> out(in.size());
  Vec3 sum = static_cast<double>(window) * in.front();  // before the start: at rest
  for (std::size_t i = 0; i < in.size(); ++i) {
    sum += in[i] - (i >= window ? in[i - window] : in.front());
    out[i] = sum / static_cast<double>(window);
  }
  return out;
}

// The curve run at constant speed and averaged twice over a short window: corners are rounded and slower, the
// speed never exceeds the given one, and the start is smooth. Tabulated; a look-up is linear interpolation.
class PathDevice final : public Device {
 public:
  PathDevice(const PathShape& shape, double speed, Disturbance disturbance)
      : speed_(speed), disturbance_(disturbance) {
    const Curve curve(shape);
    const double window = std::min(0.010, curve.loop_length() / 8);
    const std::size_t half = 16;
    // The step divides the loop, so that the table closes on itself.
    const auto steps =
        std::max<std::size_t>(64, static_cast<std::size_t>(std::ceil(curve.loop_length() / (window / 32))));
    step_ = curve.loop_length() / static_cast<double>(steps);
    const std::size_t before = static_cast<std::size_t>(std::ceil(curve.loop_start() / step_)) + 2 * half + 1;
    std::vector<Vec3> table(before + steps + 1);
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = curve.at(static_cast<double>(i) * step_);
    table_ = sliding_mean(sliding_mean(table, half), half);
    loop_start_ = static_cast<double>(before) * step_;
    loop_length_ = static_cast<double>(steps) * step_;
  }

  Vec3 position(double t, const Vec3&) noexcept override {
    double s = speed_ * std::max(t, 0.0);
    if (s > loop_start_) s = loop_start_ + std::fmod(s - loop_start_, loop_length_);
    const double place = s / step_;
    const std::size_t i = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    const double w = place - static_cast<double>(i);
    return (1 - w) * table_[i] + w * table_[i + 1] + disturbance_.at(std::max(t, 0.0));
  }
  double duration() const override { return std::numeric_limits<double>::infinity(); }

 private:
  double speed_, step_ = 0, loop_start_ = 0, loop_length_ = 0;
  std::vector<Vec3> table_;
  Disturbance disturbance_;
};

class TraceDevice final : public Device {
 public:
  TraceDevice(std::vector<double> times, std::vector<Vec3> positions)
      : times_(std::move(times)), positions_(std::move(positions)), slopes_(times_.size(), Vec3::Zero()) {
    for (std::size_t i = 1; i + 1 < times_.size(); ++i)
      slopes_[i] = (positions_[i + 1] - positions_[i - 1]) / (times_[i + 1] - times_[i - 1]);
  }

  Vec3 position(double t, const Vec3&) noexcept override {
    if (t <= times_.front()) return positions_.front();
    if (t >= times_.back()) return positions_.back();
    const auto i =
        static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), t) - times_.begin());
    const double span = times_[i] - times_[i - 1], w = (t - times_[i - 1]) / span;
    const double w2 = w * w, w3 = w2 * w;
    return (2 * w3 - 3 * w2 + 1) * positions_[i - 1] + (3 * w2 - 2 * w3) * positions_[i] +
           span * ((w3 - 2 * w2 + w) * slopes_[i - 1] + (w3 - w2) * slopes_[i]);
  }
  double duration() const override { return times_.back(); }

 private:
  std::vector<double> times_;
  std::vector<Vec3> positions_, slopes_;
};

using Settings = std::map<std::string, std::string>;

double take_number(Settings& settings, const std::string& spec, const std::string& key, double fallback,
                   double low) {
  const auto found = settings.find(key);
  if (found == settings.end()) return fallback;
  double value = 0;
  const std::string& text = found->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < low)
    throw InputError({.key = "device", .value = spec},
                     fmt::format("{} is '{}', expected a number of at least {}", key, text, low));
  settings.erase(found);
  return value;
}

void reject_rest(const Settings& settings, const std::string& spec, const std::string& accepted) {
  if (!settings.empty())
    throw InputError({.key = "device", .value = spec},
                     fmt::format("unknown setting '{}', expected {}", settings.begin()->first, accepted));
}

// "NAME,key=value,…" into name and settings.
std::string take_name(std::string arguments, const std::string& spec, Settings& settings) {
  std::string name;
  for (bool first = true; first || !arguments.empty(); first = false) {
    const std::size_t comma = arguments.find(',');
    const std::string part = arguments.substr(0, comma);
    arguments = comma == std::string::npos ? "" : arguments.substr(comma + 1);
    const std::size_t equals = part.find('=');
    if (first)
      name = part;
    else if (equals == std::string::npos)
      throw InputError({.key = "device", .value = spec},
                       fmt::format("'{}' is not a setting, expected key=value", part));
    else if (!settings.emplace(part.substr(0, equals), part.substr(equals + 1)).second)
      throw InputError({.key = "device", .value = spec},
                       fmt::format("'{}' is given twice, expected it once", part.substr(0, equals)));
  }
  if (name.empty()) throw InputError({.key = "device", .value = spec}, "expected a name after the colon");
  return name;
}

// Takes its settings out and leaves the rest.
std::unique_ptr<Device> take_path(const std::string& spec, const std::string& name, Settings& settings,
                                  const DeviceContext& context) {
  PathShape shape = path_shape(name, context);
  const double speed = take_number(settings, spec, "speed", 0.06, 1e-6);
  const double amplitude = take_number(settings, spec, "amplitude", 0, 1e-6);
  const double tremor = take_number(settings, spec, "tremor", 0, 0);
  const double noise = take_number(settings, spec, "noise", 0, 0);
  for (const auto& [key, value, most] : {std::tuple{"speed", speed, 1000.0},
                                         {"amplitude", amplitude, 10.0},
                                         {"tremor", tremor, 1.0},
                                         {"noise", noise, 1.0}})
    if (value > most)
      throw InputError({.key = "device", .value = spec},
                       fmt::format("{} is {:g}, expected at most {:g} {}", key, value, most,
                                   key == std::string_view("speed") ? "m/s" : "m"));
  if (amplitude > 0) {
    double farthest = 0;
    for (const auto* part : {&shape.lead, &shape.loop})
      for (const Vec3& p : *part) farthest = std::max(farthest, p.norm());
    for (auto* part : {&shape.lead, &shape.loop})
      for (Vec3& p : *part) p *= amplitude / farthest;
  }
  return std::make_unique<PathDevice>(shape, speed, Disturbance(tremor, noise, context.seed));
}

std::unique_ptr<Device> make_path(const std::string& spec, const std::string& name, Settings settings,
                                  const DeviceContext& context) {
  auto device = take_path(spec, name, settings, context);
  reject_rest(settings, spec, "speed, amplitude, tremor, noise");
  return device;
}

double take_grip(Settings& settings, const std::string& spec) {
  constexpr std::pair<const char*, double> words[] = {{"light", 100}, {"medium", 300}, {"firm", 800}};
  const auto found = settings.find("grip");
  if (found == settings.end()) return HandOptions{}.grip;
  for (const auto& [word, stiffness] : words)
    if (found->second == word) {
      settings.erase(found);
      return stiffness;
    }
  if (found->second.find_first_not_of("0123456789.e+-") != std::string::npos)
    throw InputError(
        {.key = "device", .value = spec},
        fmt::format("grip is '{}', expected light, medium, firm or a stiffness [N/m]", found->second));
  return take_number(settings, spec, "grip", 0, 1);
}

std::unique_ptr<Device> make_hand(const std::string& spec, const std::string& name, Settings settings,
                                  const DeviceContext& context) {
  const HandProfile* profile = find_hand_profile(name);
  if (!profile)
    throw InputError(
        {.key = "device", .value = spec},
        fmt::format("unknown profile '{}', expected one of {}", name, fmt::join(hand_profile_names(), ", ")));
  std::string target = "press";
  if (const auto found = settings.find("target"); found != settings.end()) {
    target = found->second;
    settings.erase(found);
  }
  const double grip = take_grip(settings, spec);
  auto path = take_path(spec, target, settings, context);
  reject_rest(settings, spec, "target, grip, speed, amplitude, tremor, noise");
  return make_hand_device(*profile, std::move(path), {.grip = grip});
}

Vec3 parse_offset(const std::string& spec, std::string text) {
  std::replace(text.begin(), text.end(), '/', ' ');
  Vec3 offset;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int i = 0; i < 3; ++i) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, offset[i]);
    if (error != std::errc{} || !std::isfinite(offset[i]) || (i == 2 && next != end))
      throw InputError({.key = "device", .value = spec},
                       "offset is not X/Y/Z, expected three finite numbers [m]");
    at = next;
  }
  return offset;
}

std::unique_ptr<Device> make_trace(const std::string& spec, const std::string& name, Settings settings,
                                   const DeviceContext& context) {
  const double scale = take_number(settings, spec, "scale", 1, -1e9);
  Vec3 offset = Vec3::Zero();
  if (const auto found = settings.find("offset"); found != settings.end()) {
    offset = parse_offset(spec, found->second);
    settings.erase(found);
  }
  reject_rest(settings, spec, "scale, offset");
  std::filesystem::path file = name;
  if (file.is_relative() && std::filesystem::exists(context.folder / file)) file = context.folder / file;
  Trace trace = read_trace(file);
  for (Vec3& p : trace.positions) p = scale * p + offset;
  return make_trace_device(std::move(trace.times), std::move(trace.positions));
}

}  // namespace

std::unique_ptr<Device> make_device(const std::string& spec, const DeviceContext& context) {
  const std::size_t colon = spec.find(':');
  const std::string kind = spec.substr(0, colon);
  if (kind != "path" && kind != "trace" && kind != "hand")
    throw InputError({.key = "device", .value = spec},
                     fmt::format("unknown kind '{}', expected path:NAME, trace:FILE or hand:PROFILE", kind));
  Settings settings;
  const std::string name =
      take_name(colon == std::string::npos ? "" : spec.substr(colon + 1), spec, settings);
  if (kind == "hand") return make_hand(spec, name, std::move(settings), context);
  return kind == "path" ? make_path(spec, name, std::move(settings), context)
                        : make_trace(spec, name, std::move(settings), context);
}

std::unique_ptr<Device> make_trace_device(std::vector<double> times, std::vector<Vec3> positions) {
  return std::make_unique<TraceDevice>(std::move(times), std::move(positions));
}

Trace read_trace(const std::filesystem::path& file) {
  constexpr std::string_view columns[] = {"t", "x", "y", "z"};
  const CsvTable table = read_csv(file, columns);
  Trace trace;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double t = table.at(i, 0) - table.at(0, 0);
    const Vec3 x(table.at(i, 1), table.at(i, 2), table.at(i, 3));
    if (!trace.times.empty() && t < trace.times.back())
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("time goes back to {} s after {} s, expected growing times",
                                   table.at(i, 0), trace.times.back() + table.at(0, 0)));
    if (!trace.times.empty() && t == trace.times.back())
      throw InputError({.file = file.string(), .line = table.lines[i]},
                       fmt::format("a second row at {} s, expected growing times", table.at(i, 0)));
    trace.times.push_back(t);
    trace.positions.push_back(x);
  }
  return trace;
}

}  // namespace forefeel
