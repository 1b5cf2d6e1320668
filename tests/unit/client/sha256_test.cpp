#include "client/session/sha256.h"

#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace granary::session {
namespace {

// FIPS 180-2, appendix B.1 and B.2.
TEST(Sha256, gives_the_standard_s_examples) {
  Sha256 abc;
  abc.add("abc");
  EXPECT_EQ(abc.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Sha256 in_pieces;
  in_pieces.add("abcdbcdecdefdefgefghfghighijhijk");
  in_pieces.add("ijkljklmklmnlmnomnopnopq");
  EXPECT_EQ(in_pieces.hex(), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, of_a_file_is_that_of_its_bytes) {
  const test::ScratchDirectory scratch;
  const std::string text(3 << 20, 'x');  // more than one block
  Sha256 expected;
  expected.add(text);
  EXPECT_EQ(*sha256_of_file(scratch.write("f", text)), expected.hex());
  EXPECT_EQ(sha256_of_file(scratch.file("none")).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace granary::session
