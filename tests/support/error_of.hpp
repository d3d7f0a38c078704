#pragma once

// The error line of refused input.

#include <string>

#include "geometry/common/error.hpp"

namespace forefeel::test {

// The text of the InputError thrown by `work`; empty if none was thrown.
std::string error_of(auto&& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace forefeel::test
