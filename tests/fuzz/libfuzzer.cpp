// The entry of libFuzzer for one target: FOREFEEL_FUZZ_TARGET, a name in the list that FOREFEEL_FUZZ_LIST returns.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "tests/fuzz/targets.hpp"

namespace {

const forefeel::fuzz::Target& chosen() {
  static const auto list = forefeel::fuzz::FOREFEEL_FUZZ_LIST();
  for (const forefeel::fuzz::Target& target : list)
    if (target.name == std::string_view(FOREFEEL_FUZZ_TARGET)) return target;
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const forefeel::fuzz::Target& target = chosen();
  try {
    forefeel::fuzz::run_target(target, {reinterpret_cast<const char*>(data), size});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", target.name, error.what());
    std::abort();
  }
  return 0;
}
