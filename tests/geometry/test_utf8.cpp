// Bytes that are not UTF-8, against iconv(3).

#include <iconv.h>

#include "geometry/common/utf8.hpp"
#include "tests/support/test.hpp"

namespace {

bool iconv_takes(std::string text) {
  const iconv_t converter = iconv_open("UTF-32LE", "UTF-8");
  std::string out(4 * text.size() + 16, '\0');
  char *in = text.data(), *to = out.data();
  std::size_t left = text.size(), room = out.size();
  const bool taken = iconv(converter, &in, &left, &to, &room) != static_cast<std::size_t>(-1);
  iconv_close(converter);
  return taken;
}

}  // namespace

TEST_CASE("characters of UTF-8 stay, other bytes become U+FFFD") {
  CHECK(valid_utf8("plain") == "plain");
  CHECK(valid_utf8("Stärke µ … 𝛿") == "Stärke µ … 𝛿");
  CHECK(valid_utf8("a\xff\xfe") == "a\ufffd\ufffd");
  CHECK(valid_utf8("\xc3") == "\ufffd");                                // cut
  CHECK(valid_utf8("\xc0\xaf") == "\ufffd\ufffd");                      // overlong
  CHECK(valid_utf8("\xed\xa0\x80") == "\ufffd\ufffd\ufffd");            // a surrogate
  CHECK(valid_utf8("\xf4\x90\x80\x80") == "\ufffd\ufffd\ufffd\ufffd");  // above U+10FFFF
  CHECK(valid_utf8(std::string_view("a\0b\x01\tc\n", 7)) ==
        "a\ufffd"
        "b\ufffd\tc\n");
}

TEST_CASE("a terminal gets no byte that it acts upon") {
  CHECK(printable("Stärke 5 µm\n\tnext") == "Stärke 5 µm\n\tnext");
  CHECK(printable("\x1b[31mfoo\x07") == "\ufffd[31mfoo\ufffd");
  CHECK(printable("a\r\x7f\xc2\x9b") == "a\ufffd\ufffd\ufffd");  // U+009B opens a sequence as ESC [ does
}

TEST_CASE("random bytes become text that iconv takes; text that iconv takes stays") {
  std::mt19937 random(3);
  const std::string likely = "a\xc3\xa4\xe2\x82\xac\xf0\x9d\x9b\xbf\xed\xef\x80\xff";
  std::size_t kept = 0, mended = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (unsigned length = random() % 6; length > 0; --length) text += likely[random() % likely.size()];
    INFO(text);
    const std::string valid = valid_utf8(text);
    REQUIRE(iconv_takes(valid));
    REQUIRE(valid_utf8(valid) == valid);
    if (!iconv_takes(text)) REQUIRE(valid != text);
    ++(valid == text ? kept : mended);
  }
  CHECK(kept > 1000);
  CHECK(mended > 1000);
}
