#pragma once

// The text of files written by a command.

#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/executable.hpp"

namespace forefeel::test {

// The whole of a file of the workshop; empty where there is none.
inline std::string file_text(const Workshop& shop, const std::string& name) {
  std::ifstream in(shop.path() / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace forefeel::test
