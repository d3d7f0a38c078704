#include "apps/generate/kept_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_outcome.hpp"

namespace forefeel {

KeptStates::KeptStates(StateFile file, std::size_t known, std::stop_source stop)
    : writer_(std::move(file)), known_(known), stop_(std::move(stop)) {}

void KeptStates::keep(State state) {
  if (failed()) return;
  const Kind kind = !state.usable()                ? Kind::failed
                    : has_inverted_elements(state) ? Kind::inverted
                                                   : Kind::solved;
  try {
    writer_.push(std::move(state));
    pushed_.push_back(kind);
  } catch (const InputError& problem) {
    take_failure(problem.what());
  }
}

void KeptStates::flush() {
  if (failed()) return;
  try {
    writer_.flush();
  } catch (const InputError& problem) {
    take_failure(problem.what());
  }
}

void KeptStates::take_failure(const std::string& problem) {
  failure_ = problem;
  stop_.request_stop();
}

std::size_t KeptStates::in_file() const {
  return known_ + writer_.written();
}

void KeptStates::correct(std::size_t& solved, std::size_t& failed, std::size_t& inverted) const {
  const auto end = pushed_.begin() + static_cast<std::ptrdiff_t>(writer_.written());
  const auto count = [&](Kind kind) {
    return static_cast<std::size_t>(std::count(pushed_.begin(), end, kind));
  };
  inverted = count(Kind::inverted);
  solved = count(Kind::solved) + inverted;
  failed = count(Kind::failed);
}

std::string KeptStates::in_words() const {
  return fmt::format("{}; {} kept in it; free some space, then rerun the same command to resume", *failure_,
                     counted(in_file(), "state is", "states are"));
}

}  // namespace forefeel
