#include "apps/scene/spec_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "geometry/common/error.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace_file.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {
namespace {

// The settings of each kind of device: those that are accepted, in this order, and what `forefeel help` says.

std::vector<Declared> path_settings() {
  const PathMotion motion;
  return {
      {"speed", "m/s", fmt::format("{}", usual_speed), "speed along the path"},
      {"amplitude", "m", "fits the box", "distance of the path's farthest point from rest"},
      {"tremor", "m", fmt::format("{}", motion.tremor), "RMS per axis of a tremor of 8 to 12 Hz"},
      {"noise", "m", fmt::format("{}", motion.noise), "RMS per axis of white noise"},
      {"pause", "s", fmt::format("{}", motion.pause), "at rest at each turn of more than 45 degrees"},
      {"depth", "m", "0.6 of state_space.depth", "with contact.anywhere: into the body"},
      {"where", "", "all", "with contact.anywhere: part of the surface, x/y/z/radius [m] or a node group"}};
}

std::vector<Declared> trait_settings() {
  const HandTraits usual;
  const auto shown = [](double value) { return fmt::format("{}", value); };
  return {
      {"mass", "kg", shown(usual.mass), "of hand and device"},
      {"zeta", "1", shown(usual.damping_ratio), "damping ratio of the grip, below 1"},
      {"stiffening", "1", shown(usual.stiffening),
       "the grip is stiffer by this share after a surprising force; 0: no reaction"},
      {"surprise", "N", shown(usual.surprise), "change of the force within 0.1 s that counts as a surprise"},
      {"delay", "s", shown(usual.delay), "time from the surprise to the reaction"},
      {"calm", "s", shown(usual.calm), "time in which the reaction falls to 37 %"},
      {"drawn", "", "no",
       "yes: grip (about the one given), mass, zeta, tremor and reaction are drawn from the seed"}};
}

std::vector<Declared> hand_settings() {
  std::vector<Declared> all{
      {"target", "", "press",
       "path that the hand tries to follow: a NAME of path; with contact.anywhere palpation"},
      {"grip", "N/m", fmt::format("{}", HandMotion{}.grip),
       "stiffness of the grip; also light, medium or firm"}};
  for (Declared& setting : path_settings()) all.push_back(std::move(setting));
  for (Declared& setting : trait_settings()) all.push_back(std::move(setting));
  return all;
}

std::vector<Declared> trace_settings() {
  return {
      {"scale", "1", fmt::format("{}", TraceMotion{}.scale), "factor of the positions in the file"},
      {"offset", "m", "0/0/0", "X/Y/Z, added to the scaled positions"},
      {"register", "m", "none",
       "X/Y/Z, with contact.anywhere: the first sample is put on the surface nearest to this, the motion's z "
       "axis along the normal there; offset is then in these axes, 0/0/-0.005 presses 5 mm in"},
      {"columns", "", "t/x/y/z",
       "names of the header, or numbers of columns counted from 1; - for a coordinate that is zero; x/y/z "
       "beside a rate"},
      {"rate", "Hz", "none", "samples in a second, for a file without a time column"},
      {"unit", "", "m/s", "of positions and times: m, cm or mm, s, ms, us or ns, or both, as mm/ms"},
      {"tool", "", "none",
       "one of several tools in the file: its name in a column of names, or what its own columns begin "
       "with (left_x, left_y, left_z)"}};
}

// "KIND:NAME,key=value,…"
struct Parts {
  InputPlace where;
  std::string kind, name;
  std::map<std::string, std::string> settings;  // those that were not taken yet
  std::vector<std::string> known = {};          // settings of this kind

  std::optional<std::string> take(const std::string& key) {
    if (std::ranges::find(known, key) == known.end())
      throw std::logic_error("the setting " + key + " of device " + kind + " is read but not declared");
    const auto found = settings.find(key);
    if (found == settings.end()) return {};
    std::string value = std::move(found->second);
    settings.erase(found);
    return value;
  }
  std::optional<double> take_number(const std::string& key, double low) {
    const std::optional<std::string> text = take(key);
    if (!text) return {};
    double value = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (error != std::errc{} || end != text->data() + text->size() || !std::isfinite(value) || value < low)
      throw InputError(where, fmt::format("{} is '{}', expected a number of at least {}", key, *text, low));
    return value;
  }
  void reject_rest() const {
    if (!settings.empty())
      throw InputError(where, fmt::format("unknown setting '{}', expected {}", settings.begin()->first,
                                          fmt::join(known, ", ")));
  }
};

std::string kind_of(const std::string& text) {
  return text.substr(0, text.find(':'));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(separator, begin)) != std::string::npos; begin = end + 1)
    parts.push_back(text.substr(begin, end - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

std::pair<std::string, std::string> setting_of(const InputPlace& where, const std::string& part) {
  const std::size_t equals = part.find('=');
  if (equals == std::string::npos)
    throw InputError(where, fmt::format("'{}' is not a setting, expected key=value", part));
  return {part.substr(0, equals), part.substr(equals + 1)};
}

Parts parts_of(const std::string& text, const std::vector<Declared>& settings) {
  Parts parts{.where = {.key = "device", .value = text},
              .kind = kind_of(text),
              .name = {},
              .settings = {},
              .known = names_of(settings)};
  const std::size_t colon = text.find(':');
  std::vector<std::string> all = split(colon == std::string::npos ? "" : text.substr(colon + 1), ',');
  parts.name = all.front();
  if (all.size() > 1 && all.back().empty()) all.pop_back();  // a comma at the end
  for (std::size_t i = 1; i < all.size(); ++i) {
    auto [key, value] = setting_of(parts.where, all[i]);
    if (!parts.settings.emplace(key, std::move(value)).second)
      throw InputError(parts.where, fmt::format("'{}' is given twice, expected it once", key));
  }
  if (parts.name.empty()) throw InputError(parts.where, "expected a name after the colon");
  return parts;
}

template <class Name>
std::optional<Name> find_name(const std::vector<std::string>& names, const std::string& text) {
  const auto found = std::ranges::find(names, text);
  if (found == names.end()) return {};
  return static_cast<Name>(found - names.begin());  // names are in the order of the enumeration
}

PathMotion take_path(const std::string& name, Parts& parts) {
  const auto path = find_name<PathName>(path_names(), name);
  if (!path)
    throw InputError(
        "device", fmt::format("unknown path '{}', expected one of {}", name, fmt::join(path_names(), ", ")));
  PathMotion motion{.path = *path, .speed = parts.take_number("speed", 1e-6)};
  motion.amplitude = parts.take_number("amplitude", 1e-6).value_or(motion.amplitude);
  motion.tremor = parts.take_number("tremor", 0).value_or(motion.tremor);
  motion.noise = parts.take_number("noise", 0).value_or(motion.noise);
  motion.pause = parts.take_number("pause", 0).value_or(motion.pause);
  motion.depth = parts.take_number("depth", 1e-6);
  motion.where = parts.take("where").value_or("");
  check(DeviceSpec(motion, *parts.where.value));
  return motion;
}

PathMotion path_of(Parts parts) {
  const PathMotion motion = take_path(parts.name, parts);
  parts.reject_rest();
  return motion;
}

double take_grip(Parts& parts) {
  constexpr std::pair<const char*, double> words[] = {{"light", 100}, {"medium", 300}, {"firm", 800}};
  const auto found = parts.settings.find("grip");
  if (found == parts.settings.end()) return HandMotion{}.grip;
  for (const auto& [word, stiffness] : words)
    if (found->second == word) {
      parts.settings.erase(found);
      return stiffness;
    }
  if (found->second.find_first_not_of("0123456789.e+-") != std::string::npos)
    throw InputError(
        parts.where,
        fmt::format("grip is '{}', expected light, medium, firm or a stiffness [N/m]", found->second));
  return *parts.take_number("grip", 1);
}

HandTraits take_traits(Parts& parts) {
  HandTraits traits;
  traits.mass = parts.take_number("mass", 1e-3).value_or(traits.mass);
  traits.damping_ratio = parts.take_number("zeta", 0).value_or(traits.damping_ratio);
  traits.stiffening = parts.take_number("stiffening", 0).value_or(traits.stiffening);
  traits.surprise = parts.take_number("surprise", 1e-3).value_or(traits.surprise);
  traits.delay = parts.take_number("delay", 0).value_or(traits.delay);
  traits.calm = parts.take_number("calm", 1e-3).value_or(traits.calm);
  if (const auto drawn = parts.take("drawn")) {
    if (*drawn != "yes" && *drawn != "no")
      throw InputError(parts.where, fmt::format("drawn is '{}', expected yes or no", *drawn));
    traits.drawn = *drawn == "yes";
  }
  return traits;
}

HandMotion hand_of(Parts parts) {
  const auto profile = find_name<HandName>(hand_names(), parts.name);
  if (!profile)
    throw InputError(parts.where, fmt::format("unknown profile '{}', expected one of {}", parts.name,
                                              fmt::join(hand_names(), ", ")));
  const std::string target = parts.take("target").value_or("press");
  const double grip = take_grip(parts);
  const HandMotion motion{
      .profile = *profile, .target = take_path(target, parts), .grip = grip, .traits = take_traits(parts)};
  parts.reject_rest();
  check(DeviceSpec(motion, *parts.where.value));
  return motion;
}

Vec3 point_from(const InputPlace& where, const char* key, std::string text) {
  std::ranges::replace(text, '/', ' ');
  Vec3 offset;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int i = 0; i < 3; ++i) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, offset[i]);
    if (error != std::errc{} || !std::isfinite(offset[i]) || (i == 2 && next != end))
      throw InputError(where, fmt::format("{} is not X/Y/Z, expected three finite numbers [m]", key));
    at = next;
  }
  return offset;
}

void take_format(Parts& parts, TraceFormat& format) {
  format.rate = parts.take_number("rate", 1e-3).value_or(format.rate);
  if (const auto columns = parts.take("columns")) {
    format.columns = split(*columns, '/');
    const std::size_t wanted = format.rate == 0 ? 4 : 3;
    if (format.columns.size() != wanted || std::ranges::find(format.columns, "") != format.columns.end())
      throw InputError(parts.where,
                       fmt::format("columns is '{}', expected {}", *columns,
                                   wanted == 4 ? "t/x/y/z, names or numbers from 1 (x/y/z beside a rate)"
                                               : "x/y/z, names or numbers from 1, as a rate is given"));
  }
  if (const auto unit = parts.take("unit"); unit && !parse_trace_unit(*unit, format))
    throw InputError(parts.where,
                     fmt::format("unit is '{}', expected m, cm or mm, s, ms, us or ns, or one of "
                                 "each, as mm/ms",
                                 *unit));
  if (auto tool = parts.take("tool")) format.tool = std::move(*tool);
}

TraceMotion trace_of(Parts parts) {
  TraceMotion motion{.file = parts.name};
  motion.scale = parts.take_number("scale", -1e9).value_or(motion.scale);
  if (const auto offset = parts.take("offset")) motion.offset = point_from(parts.where, "offset", *offset);
  if (const auto place = parts.take("register")) motion.placed = point_from(parts.where, "register", *place);
  take_format(parts, motion.format);
  parts.reject_rest();
  check(DeviceSpec(motion, *parts.where.value));
  return motion;
}

double cost_number(const InputPlace& where, const std::string& text, double low, bool open) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < low ||
      value > 1e6 || (open && value == low))
    throw InputError(where, fmt::format("'{}' is not a number {} {} and at most 1e6", text,
                                        open ? "above" : "of at least", low));
  return value;
}

LogNormalCost lognormal_of(const InputPlace& where, const std::string& arguments) {
  const std::size_t comma = arguments.find(',');
  if (comma == std::string::npos) throw InputError(where, "expected lognormal:MEDIAN,SIGMA");
  const double median = cost_number(where, arguments.substr(0, comma), 0, true);
  return {.median = median, .sigma = cost_number(where, arguments.substr(comma + 1), 0, false)};
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

DeviceSpec device_from_text(const std::string& text) {
  const std::string kind = kind_of(text);
  if (kind == "path") return {path_of(parts_of(text, path_settings())), text};
  if (kind == "trace") return {trace_of(parts_of(text, trace_settings())), text};
  if (kind == "hand") return {hand_of(parts_of(text, hand_settings())), text};
  if (among(registered_devices(), kind)) return {part_from_text("device", text), text};
  throw InputError({.key = "device", .value = text},
                   fmt::format("unknown kind '{}', expected {}", kind, device_kinds()));
}

CostSpec cost_from_text(const std::string& text) {
  const InputPlace where{.key = "cost", .value = text};
  const std::string kind = kind_of(text);
  const std::string arguments = kind.size() == text.size() ? "" : text.substr(kind.size() + 1);
  if (kind == "constant") return {ConstantCost{cost_number(where, arguments, 0, true)}, text};
  if (kind == "lognormal") return {lognormal_of(where, arguments), text};
  if (text == "paper") return {PaperCost{}, text};
  if (text == "recorded") return {RecordedCost{}, text};
  if (among(registered_costs(), kind)) return {part_from_text("cost", text), text};
  throw InputError(where, fmt::format("unknown model, expected {}", cost_kinds()));
}

Registered part_from_text(const std::string& kind, const std::string& text) {
  const InputPlace where{.key = kind, .value = text};
  Registered part(kind_of(text));
  if (part.name.size() == text.size()) return part;
  const std::vector<std::string> all = split(text.substr(part.name.size() + 1), ',');
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 && all[i].find('=') == std::string::npos)
      part.settings.emplace_back("", all[i]);
    else
      part.settings.push_back(setting_of(where, all[i]));
  }
  return part;
}

std::vector<DeclaredTable> device_tables() {
  const auto with = [](const char* name, const std::string& meaning, std::vector<Declared> settings) {
    settings.insert(settings.begin(), {name, "", "required", meaning});
    return settings;
  };
  const auto any_of = [](const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, " | "));
  };
  std::vector<DeclaredTable> tables{
      {"path", "path:NAME,key=value,… A closed curve, repeated without end.",
       with("NAME", any_of(path_names()), path_settings())},
      {"trace", "trace:FILE,key=value,… A recorded motion.",
       with("FILE", "a table of numbers, relative to the scene; t,x,y,z in s and m unless said otherwise",
            trace_settings())},
      {"hand", "hand:PROFILE,key=value,… A hand that holds a device and yields to its force.",
       with("PROFILE", any_of(hand_names()), hand_settings())}};
  DeclaredTable curves{"curves", "The NAMEs of path, in the box of states.", {}};
  for (std::size_t i = 0; i < path_names().size(); ++i)
    curves.rows.push_back({path_names()[i], "", "", std::string(path_in_words(static_cast<PathName>(i)))});
  tables.insert(tables.begin() + 1, std::move(curves));
  for (const std::string& name : registered_devices())
    tables.push_back({name, name + ":key=value,… Registered by this program.", {}});
  return tables;
}

DeclaredTable cost_table() {
  DeclaredTable table{"cost",
                      "--cost or session.cost: time of a solve under the virtual clock.",
                      {{"constant:SECONDS", "s", to_text(CostSpec()), "always the same"},
                       {"lognormal:MEDIAN,SIGMA", "s", "", "log-normal; SIGMA is that of the logarithm"},
                       {"paper", "", "", "log-normal, 95 % between 0.1 and 1 s, clamped to it"},
                       {"recorded", "", "", "measured by real solves of this body and kept in the cache"}}};
  for (const std::string& name : registered_costs())
    table.rows.push_back({name, "", "", "registered by this program"});
  return table;
}

}  // namespace forefeel
