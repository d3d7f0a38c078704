#pragma once

// What the tests of the commands' contract share: JSON of a run, its keys, and an interrupted run.

#include "tests/support/executable.hpp"

namespace forefeel::test {

// Checks that every path in `keys` ("deadline.cost_us.p50") exists.
inline void check_keys(const json& document, const std::vector<std::string>& keys) {
  for (const std::string& path : keys) {
    const json* here = &document;
    std::string part;
    bool there = true;
    for (std::istringstream in(path); there && std::getline(in, part, '.');) {
      there = here->is_object() && here->contains(part);
      if (there) here = &here->at(part);
    }
    INFO("key " << path << " in " << document.dump().substr(0, 1500));
    CHECK(there);
  }
}

// Runs the command and sends SIGINT `seconds` after the shell's condition `begun` holds. The command ends with 1
// and reports it. The signal is sent twice at once, as timeout(1) does; it must count as one.
inline Workshop::Outcome run_interrupted(const Workshop& shop, const std::string& arguments,
                                         const std::string& begun, double seconds) {
  const Workshop::Outcome outcome =
      shop.shell(executable() + " " + arguments + " --json & p=$!; " + wait_until(begun) + "sleep " +
                 std::to_string(seconds) + "; kill -INT $p; kill -INT $p; wait $p");
  INFO("forefeel " << arguments << " --json\n" << outcome.err);
  CHECK(outcome.code == 1);
  CHECK(outcome.json()["interrupted"] == true);
  return outcome;
}

}  // namespace forefeel::test
