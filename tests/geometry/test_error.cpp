// The text of an error is put together from its parts, and the parts are kept.

#include <catch2/catch.hpp>

#include "geometry/common/error.hpp"

namespace forefeel {

TEST_CASE("The place of an error is written as file, line, option, key and value", "[error]") {
  CHECK(InputPlace{.file = "trace.csv"}.text() == "trace.csv");
  CHECK(InputPlace{.file = "trace.csv", .line = 17}.text() == "trace.csv:17");
  CHECK(InputPlace{.file = "a.toml", .line = 9, .key = "material.poisson"}.text() ==
        "a.toml:9: material.poisson");
  CHECK(InputPlace{.file = "a.toml", .key = "clamp"}.text() == "a.toml: clamp");
  CHECK(InputPlace{.key = "device", .value = "path:press"}.text() == "device path:press");
  CHECK(InputPlace{.option = "--set", .key = "session.policy"}.text() == "--set session.policy");
  CHECK(InputPlace{.option = "--set", .key = "a.b", .value = ""}.text() == "--set a.b=");
  CHECK(InputPlace{}.empty());
  CHECK_FALSE(InputPlace{.key = "box"}.empty());
}

TEST_CASE("An error keeps its parts and says them in one line", "[error]") {
  const InputError error({.file = "a\nb.csv", .line = 2}, "holds\t'x', expected a number");
  CHECK(std::string(error.what()) == "a b.csv:2: holds 'x', expected a number");
  CHECK(error.place().file == "a\nb.csv");
  CHECK(error.place().line == 2);
  CHECK(error.problem() == "holds 'x', expected a number");
  const InputError named("model.neighbours", "is 0, expected at least 1");
  CHECK(named.place() == InputPlace{.key = "model.neighbours"});
  CHECK(std::string(named.what()) == "model.neighbours: is 0, expected at least 1");
}

}  // namespace forefeel
