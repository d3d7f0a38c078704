#pragma once
// A page of `forefeel show`, taken apart: its data, decoded independently of the command.

#include "tests/support/test.hpp"

namespace forefeel::test {

inline std::string from_base64(const std::string& text) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned word = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::size_t digit = alphabet.find(c);
    REQUIRE(digit != std::string_view::npos);
    word = word << 6 | static_cast<unsigned>(digit);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(word >> held & 255);
  }
  return bytes;
}

// {"f32": "base64"} as numbers.
template <class T>
std::vector<T> numbers(const json& packed, const char* type) {
  const std::string bytes = from_base64(packed.at(type).get<std::string>());
  REQUIRE(bytes.size() % sizeof(T) == 0);
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

inline std::vector<float> floats(const json& packed) {
  return numbers<float>(packed, "f32");
}

// Labels of a grid from its runs.
inline std::vector<int> labels(const json& grid) {
  const auto runs = numbers<std::uint8_t>(grid.at("runs"), "u8");
  std::vector<int> all;
  for (std::size_t i = 0; i + 2 < runs.size(); i += 3)
    all.insert(all.end(), runs[i + 1] + 256u * runs[i + 2], runs[i]);
  return all;
}

struct ShownPage {
  std::string text;                  // all of it
  std::vector<std::string> scripts;  // without the data
  json data;

  explicit ShownPage(const fs::path& file) : text(text_of(file)) {
    constexpr std::string_view data_tag = R"(<script id="data" type="application/json">)", tag = "<script>";
    for (std::size_t at = 0; (at = text.find("<script", at)) != std::string::npos;) {
      const std::size_t begin = text.find('>', at) + 1, end = text.find("</script>", begin);
      REQUIRE(end != std::string::npos);
      const std::string inside = text.substr(begin, end - begin);
      if (text.compare(at, data_tag.size(), data_tag) == 0) {
        data = json::parse(inside);
      } else {
        CHECK(text.compare(at, tag.size(), tag) == 0);  // nothing is loaded from a src
        scripts.push_back(inside);
      }
      at = end;
    }
  }
};

}  // namespace forefeel::test
