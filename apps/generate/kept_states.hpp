#pragma once
// Writes states to the file of `forefeel generate`. If the file can no longer be written (a full disk), solving is
// asked to stop, and the states in the file are counted.

#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "geometry/states/state_file.hpp"

namespace forefeel {

class KeptStates {
 public:
  // known: the states that the file held before.
  KeptStates(StateFile file, std::size_t known, std::stop_source stop);
  void keep(State state);  // by one thread at a time; never throws for the file
  void flush();            // what was kept is durable, or the file has failed
  bool failed() const { return failure_.has_value(); }
  std::size_t in_file() const;  // states, those of earlier runs and failed solves included
  // Corrects the counts of a run to the states that are in the file.
  void correct(std::size_t& solved, std::size_t& failed, std::size_t& inverted) const;
  // "g.states: cannot be written, the disk is full (…); 569 states are kept in it; free …"; only if failed()
  std::string in_words() const;

 private:
  enum class Kind : char { solved, inverted, failed };
  void take_failure(const std::string& problem);

  StateWriter writer_;
  std::size_t known_;
  std::stop_source stop_;
  std::vector<Kind> pushed_;
  std::optional<std::string> failure_;
};

}  // namespace forefeel
