#pragma once
// The settings that a user writes behind the name of a registered part, "mine:gain=2,file=a.csv", for the
// part's factory.
//
//   const double gain = arguments.number("gain", 1.0, 0.0, 10.0);   // default 1; InputError outside 0 to 10
//   const std::string file = arguments.text("file", "default.csv");
//
// Whoever calls the factory calls expect_all_read() after it: a setting that the factory has not asked for is
// an error that lists those it has asked for.

#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/common/error.hpp"

namespace forefeel {

// In the order in which they were written. The key is empty for a first setting without "=": "mine:a.csv".
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
  // place: for errors, as {.key = "policy", .value = "mine:gain=2"}. InputError for a key that is given
  // twice.
  Arguments(InputPlace place, const PartSettings& settings);

  bool has(const std::string& key);
  // InputError for text that is no finite number from low to high.
  double number(const std::string& key, double fallback,
                double low = -std::numeric_limits<double>::infinity(),
                double high = std::numeric_limits<double>::infinity());
  std::string text(const std::string& key, std::string fallback);
  void expect_all_read() const;

 private:
  InputPlace place_;
  std::map<std::string, std::string> values_;
  std::set<std::string> read_;
};

}  // namespace forefeel
