#pragma once
// The one exception type of the toolkit: bad input or a bad environment. Outcomes of a computation
// (a diverged solve, a duplicate state, a blank place) are values, never exceptions.

#include <stdexcept>
#include <string>
#include <utility>

namespace forefeel {

// what() is one line: "<where>: <what was wrong>, <what was expected>"; where names the file, and the key or
// line in it ("liver.toml: material.poisson", "trace.csv:17"). The command line maps it to exit code 2.
class InputError : public std::runtime_error {
 public:
  InputError(std::string where, const std::string& problem)
      : std::runtime_error(one_line(where + ": " + problem)), where_(std::move(where)) {}
  const std::string& where() const { return where_; }

 private:
  // Messages quote files, and files hold anything.
  static std::string one_line(std::string text) {
    for (char& c : text)
      if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
    return text;
  }

  std::string where_;
};

}  // namespace forefeel
