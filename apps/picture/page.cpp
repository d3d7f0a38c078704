#include "apps/picture/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "geometry/common/base64.hpp"

namespace forefeel {

std::string base64_of_whole(const std::vector<double>& values, double& scale) {
  double most = 1e-12;
  for (const double value : values) most = std::max(most, std::abs(value));
  scale = most / 32000;
  std::vector<std::int16_t> whole;
  for (const double value : values) whole.push_back(static_cast<std::int16_t>(std::lround(value / scale)));
  return base64(whole);
}

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\">\n"
      "<title>{}</title>\n<style>\n{}</style></head><body><main>\n{}</main></body></html>\n",
      html_escaped(title), page_style, body);
}

}  // namespace forefeel
