#pragma once
// The one exception type of the library: bad input or a bad environment. Outcomes of a computation (a solve
// that diverged, a duplicate state, an unknown place) are values, never exceptions.

#include <concepts>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace forefeel {

// Where an input stands. Parts that do not apply are left empty. As text():
//   {.file = "trace.csv", .line = 17}                               trace.csv:17
//   {.file = "liver.toml", .line = 9, .key = "material.poisson"}    liver.toml:9: material.poisson
//   {.option = "--set", .key = "session.policy", .value = "best"}   --set session.policy=best
//   {.key = "device", .value = "path:press"}                        device path:press
struct InputPlace {
  std::string file = {};    // a file or folder
  std::size_t line = 0;     // in the file, from 1; 0: none
  std::string option = {};  // the option that sets a key of a scene
  std::string key = {};     // a key of the file, an option of the command line, or a part of the library
  std::optional<std::string> value = {};  // as written, where the message shows it with the key

  bool empty() const { return *this == InputPlace{}; }
  std::string text() const;
  bool operator==(const InputPlace&) const = default;
};

// what() is one line: "<place>: <problem>", and the problem says what was wrong and what was expected. The
// command line maps it to exit code 2.
class InputError : public std::runtime_error {
 public:
  InputError(InputPlace place, const std::string& problem)
      : std::runtime_error(one_line(place.text() + ": " + problem)),
        place_(std::move(place)),
        problem_(one_line(problem)) {}
  // A place that is only a key: InputError("model.neighbours", "is 0, expected at least 1").
  template <std::convertible_to<std::string> Key>
  InputError(Key&& key, const std::string& problem)
      : InputError(InputPlace{.key = std::forward<Key>(key)}, problem) {}

  const InputPlace& place() const { return place_; }
  const std::string& problem() const { return problem_; }  // what() without the place

 private:
  // Messages quote files, and files hold anything: control characters become spaces.
  static std::string one_line(std::string text);

  InputPlace place_;
  std::string problem_;
};

}  // namespace forefeel
