// SHA-256 against the examples of FIPS 180-4.

#include "geometry/common/sha256.hpp"
#include "tests/support/test.hpp"

TEST_CASE("SHA-256 of the standard's examples", "[sha256]") {
  CHECK(Sha256{}.hex() == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(Sha256{}.add("abc").hex() == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(Sha256{}.add("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex() ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  Sha256 million;
  for (int i = 0; i < 1000; ++i) million.add(std::string(1000, 'a'));
  CHECK(million.hex() == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("SHA-256 does not depend on how the bytes are divided", "[sha256]") {
  const std::string text(1000, 'x');
  const std::string whole = Sha256{}.add(text).hex();
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    Sha256 parts;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t n = std::min<std::size_t>(random() % 150, text.size() - at);
      parts.add(std::string_view(text).substr(at, n));
      at += n;
    }
    CHECK(parts.hex() == whole);
  }
  CHECK(Sha256{}.add(0.0).hex() == Sha256{}.add(-0.0).hex());
  CHECK(Sha256{}.add(1.0).hex() != Sha256{}.add(std::int64_t{1}).hex());
}
