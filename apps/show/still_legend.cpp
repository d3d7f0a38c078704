#include "apps/show/still_legend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "apps/picture/palette.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_named_regions = 8;

// The legend at the right: what each colour stands for, with numbers.
class Legend {
 public:
  explicit Legend(FlatPicture& picture) : picture_(picture) {}
  void swatch(std::string_view meaning, const std::string& words) { patch(ink(meaning), words); }
  void patch(const std::string& colour, const std::string& words) {
    picture_.polygon({{legend_left, y_ - 11},
                      {legend_left + 15, y_ - 11},
                      {legend_left + 15, y_ + 1},
                      {legend_left, y_ + 1}},
                     colour);
    words_at(legend_left + 22, words);
  }
  // Five colours from one to another.
  void ramp(const std::string& from, const std::string& to, const std::string& words) {
    constexpr int steps = 5;
    for (int i = 0; i < steps; ++i) {
      const double left = legend_left + 11.0 * i;
      picture_.polygon({{left, y_ - 11}, {left + 11, y_ - 11}, {left + 11, y_ + 1}, {left, y_ + 1}},
                       mixed(from, to, double(i) / (steps - 1)));
    }
    words_at(legend_left + 11 * steps + 7, words);
  }
  void words(const std::string& text) { words_at(legend_left, text); }
  void gap() { y_ += 10; }

 private:
  void words_at(double x, const std::string& text) {
    picture_.text({x, y_}, text, 13);
    y_ += 20;
  }
  FlatPicture& picture_;
  double y_ = 76;
};

std::string sides(const Box& box) {
  const Vec3 size = 1e3 * box.size();
  return fmt::format("{:.3g} x {:.3g} x {:.3g} mm", size.x(), size.y(), size.z());
}

void add_body_lines(const ShownBody& body, Legend& legend) {
  legend.swatch("body", fmt::format("body, {}", [&] {
                  ShowContent only;
                  only.body = body;
                  return sides(extent_of(only));
                }()));
  const auto has = [&](Role role) { return std::ranges::find(body.role, role) != body.role.end(); };
  for (std::size_t k = 0; k < std::min(body.regions.all.size(), most_named_regions); ++k) {
    const ShownRegion& region = body.regions.all[k];
    legend.patch(colour_of(palette_in_use(), k),
                 fmt::format("{:.24}, {:.3g} cm\u00b3", region.name, 1e6 * region.volume));
    if (!region.words.empty()) legend.words("      " + region.words);
  }
  if (!body.regions.rest_words.empty()) legend.words("the rest: " + body.regions.rest_words);
  if (body.regions.all.size() > most_named_regions)
    legend.words(fmt::format("and {} more regions", body.regions.all.size() - most_named_regions));
  if (has(Role::clamp)) legend.swatch("clamp", "clamp (held)");
  if (body.pad) legend.ramp(ink("body"), ink("contact"), in_words(*body.pad));
  if (has(Role::contact)) legend.swatch("contact", "contact (moves with the hand)");
}

}  // namespace

bool near_cut_only(const ShownStates& states) {
  return states.all.size() > 1500;
}

void add_legend(const ShowContent& content, FlatPicture& picture) {
  Legend legend(picture);
  if (content.body) add_body_lines(*content.body, legend);
  if (content.box) legend.words("box " + sides(*content.box));
  if (std::isfinite(content.spacing)) legend.words(fmt::format("spacing {:.4g} mm", 1e3 * content.spacing));
  if (content.states) {
    legend.gap();
    legend.words(fmt::format("{} states{} and a cut", content.states->all.size(),
                             near_cut_only(*content.states) ? " (dots: those near it)" : " (dots)"));
    legend.words("through the labels:");
    for (const Label label : all_labels)
      legend.swatch(name(label), fmt::format("{}, {:.4g} cm\u00b3", name(label),
                                             1e6 * content.states->regions.volume[label]));
    if (std::ranges::any_of(content.states->all, [](const ShownState& s) { return !s.state.usable(); }))
      legend.swatch("failed", "solve failed");
  }
  if (content.run) {
    double strongest = 0;
    for (const ShownFrame& f : content.run->path) strongest = std::max(strongest, f.sent.norm());
    legend.gap();
    legend.swatch("path", "path of the hand");
    legend.swatch("force", fmt::format("force, up to {:.3g} N", strongest));
  }
}

}  // namespace forefeel
