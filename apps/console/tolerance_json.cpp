#include "apps/console/tolerance_json.hpp"

#include <fmt/format.h>

namespace forefeel {
namespace {

double ratio(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : unknown;
}

}  // namespace

const JsonKeys<ToleranceShown>& tolerance_keys() {
  using T = ToleranceShown;
  static const JsonKeys<T> keys{
      {"value", "", "state_space.tolerance if the scene gives it: a share or newtons",
       [](const T& t) { return t.tolerance.value; }},
      {"unit", "", "1 or N", [](const T& t) { return t.tolerance.newtons ? "N" : "1"; }},
      {"known", "1", "share of the frames whose error bar of 95 % is at most the tolerance",
       [](const T& t) { return ratio(t.share.frames_known, t.share.frames); }},
      {"samples", "", "sampled frames", [](const T& t) { return t.share.samples; }},
      {"within", "1", "share of the samples whose error is at most the tolerance",
       [](const T& t) { return ratio(t.share.within, t.share.samples); }},
      {"samples_known", "", "samples whose error bar of 95 % is at most the tolerance",
       [](const T& t) { return t.share.known; }},
      {"known_true", "1", "share of those whose error is at most the tolerance",
       [](const T& t) { return ratio(t.share.known_true, t.share.known); }}};
  return keys;
}

std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance) {
  std::string text = fmt::format("known within {} (bar of 95 %): {:.1f} % of the time", in_words(tolerance),
                                 100 * ratio(share.frames_known, share.frames));
  if (share.known > 0)
    text += fmt::format("; true in {:.1f} % of {} samples then", 100 * ratio(share.known_true, share.known),
                        share.known);
  return text;
}

}  // namespace forefeel
