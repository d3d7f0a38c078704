#include "apps/console/tolerance_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"

namespace forefeel {
namespace {

double ratio(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : unknown;
}

}  // namespace

nlohmann::ordered_json to_json(const ToleranceShare& share, const Tolerance& tolerance) {
  return {{"value", tolerance.value},
          {"unit", tolerance.newtons ? "N" : "1"},
          {"known", number(ratio(share.frames_known, share.frames))},
          {"samples", share.samples},
          {"within", number(ratio(share.within, share.samples))},
          {"samples_known", share.known},
          {"known_true", number(ratio(share.known_true, share.known))}};
}

std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance) {
  std::string text = fmt::format("known within {} (bar of 95 %): {:.1f} % of the time", in_words(tolerance),
                                 100 * ratio(share.frames_known, share.frames));
  if (share.known > 0)
    text += fmt::format("; true in {:.1f} % of {} samples then", 100 * ratio(share.known_true, share.known),
                        share.known);
  return text;
}

std::vector<Declared> declared_tolerance() {
  return {
      {"tolerance.value", "", "", "state_space.tolerance if the scene gives it: a share or newtons"},
      {"tolerance.unit", "", "", "1 or N"},
      {"tolerance.known", "1", "", "share of the frames whose error bar of 95 % is at most the tolerance"},
      {"tolerance.samples", "", "", "sampled frames"},
      {"tolerance.within", "1", "", "share of the samples whose error is at most the tolerance"},
      {"tolerance.samples_known", "", "", "samples whose error bar of 95 % is at most the tolerance"},
      {"tolerance.known_true", "1", "", "share of those whose error is at most the tolerance"}};
}

}  // namespace forefeel
