#pragma once
// The settings that a user writes after the name of a registered part, as in "mine:gain=2,file=a.csv". The
// part's factory reads them.
//
//   const double gain = arguments.number("gain", 1.0, 0.0, 10.0);   // default 1; InputError outside 0 to 10
//   const std::string file = arguments.text("file", "default.csv");
//   const std::string other = arguments.required_text("other");     // InputError without it
//
// The caller of the factory then calls expect_all_read(). It throws InputError for a setting that the factory
// did not read; the error lists the settings that it read.

#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"

namespace forefeel {

// Settings in the order of the user's text. The key is empty for a first setting without "=", as in
// "mine:a.csv".
using PartSettings = std::vector<std::pair<std::string, std::string>>;

// A part chosen by the name that it is registered under.
struct Registered {
  Registered() = default;
  Registered(const char* a_name) : name(a_name) {}
  Registered(std::string a_name, PartSettings some = {})
      : name(std::move(a_name)), settings(std::move(some)) {}

  std::string name;
  PartSettings settings;
  friend bool operator==(const Registered&, const Registered&) = default;
};
std::string to_text(const Registered& part);  // "mine:a.csv,gain=2", as it was written

class Arguments {
 public:
  Arguments() = default;
  // place: named in errors, as {.key = "policy", .value = "mine:gain=2"}. InputError for a key given twice.
  Arguments(InputPlace place, const PartSettings& settings);

  bool has(const std::string& key);
  // InputError for text that is not a finite number between low and high.
  double number(const std::string& key, double fallback,
                double low = -std::numeric_limits<double>::infinity(),
                double high = std::numeric_limits<double>::infinity());
  std::string text(const std::string& key, std::string fallback);
  std::vector<std::string> keys() const;              // that the user wrote, sorted
  std::string required_text(const std::string& key);  // InputError where it is missing or empty
  void expect_all_read() const;

 private:
  InputPlace place_;
  std::map<std::string, std::string> values_;
  std::set<std::string> read_;
};

}  // namespace forefeel
