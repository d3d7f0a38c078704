// The text of an error is put together from its parts, and the parts are kept.

#include "tests/support/test.hpp"

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

TEST_CASE("A long input is quoted in short: no line repeats a file", "[error]") {
  const std::string flood(100'000, 'x');
  const auto line = [](const InputError& error) { return std::string(error.what()); };
  CHECK(line(InputError("policy", "'" + flood + "' is unknown, expected one of fifo, coverage")).size() <
        200);
  CHECK_THAT(line(InputError("policy", "'" + flood + "' is unknown, expected one of fifo, coverage")),
             Catch::EndsWith("is unknown, expected one of fifo, coverage"));
  CHECK(line(InputError({.option = "--set", .key = flood, .value = flood}, "is odd")).size() < 700);
  std::string words;
  for (int i = 0; i < 30'000; ++i) words += "word ";
  CHECK(line(InputError("policy", "'" + words + "' is unknown, expected fifo")).size() < 200);
  CHECK(line(InputError("policy", words + "is unknown")).size() < 1600);
  CHECK(line(InputError({.file = "/" + flood}, "cannot be read")).size() < 600);
  std::string umlauts;
  for (int i = 0; i < 50'000; ++i) umlauts += "ü";
  CHECK_THAT(line(InputError("name", umlauts + " is unknown")), Contains("ü…ü"));
  const std::string whole = "'a b' at the body's end of 'c', expected users' names";
  CHECK(InputError("name", whole).problem() == whole);
}
