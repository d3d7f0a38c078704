#pragma once
// What every file of tests includes: Catch2, the standard headers that most use, scratch folders, skipped tests.

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

// A test that takes seconds says why:
//
//   TEST_CASE("meshes converge", "[error]" SLOW("solves four meshes")) { … }
//
// Such tests run with `bash tests/run.sh all` (ctest -L slow). `test_solver --list-tests [slow]` lists the reasons.
#define SLOW(reason) "[slow][slow: " reason "]"

namespace fs = std::filesystem;

namespace forefeel::test {

// Whether this build runs under the address or thread sanitizer. Both reserve the whole address space, so that its size
// cannot be limited (ulimit -v).
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif
#else
constexpr bool sanitized = false;
#endif

// The text of the InputError thrown by `work`: the error line of refused input. Empty if none was thrown.
std::string error_of(auto&& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// The whole of a file; empty where there is none.
inline std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Matches a text that contains each of these words.
class Contains : public Catch::MatcherBase<std::string> {
 public:
  template <class... Words>
  explicit Contains(const Words&... words) : words_{words...} {}
  bool match(const std::string& text) const override {
    return std::ranges::all_of(words_, [&](const std::string& word) { return text.find(word) != text.npos; });
  }
  std::string describe() const override {
    return std::accumulate(
        words_.begin(), words_.end(), std::string("contains"),
        [](const std::string& text, const std::string& word) { return text + " \"" + word + '"'; });
  }

 private:
  std::vector<std::string> words_;
};

}  // namespace forefeel::test

using nlohmann::json;
using namespace forefeel;
using namespace forefeel::test;
