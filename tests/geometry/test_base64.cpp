#include "geometry/common/base64.hpp"
#include "tests/support/test.hpp"

TEST_CASE("base64 is that of RFC 4648 and comes back") {
  const std::pair<const char*, const char*> pairs[] = {
      {"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, text] : pairs) {
    CHECK(base64(std::string_view(plain)) == text);
    CHECK(from_base64(text) == plain);
    CHECK(base64_length(std::string_view(plain).size()) == std::string_view(text).size());
  }
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);
  CHECK(from_base64(base64(bytes)) == bytes);
  for (const char* bad : {"Zm9*", "=m9v", "Z===", "Zm\n9"}) CHECK_FALSE(from_base64(bad));
}
