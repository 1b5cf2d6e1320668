#include "client/session/file_checksum.h"

#include <gtest/gtest.h>

#include "proto/contract/sha256.h"
#include "tests/support/program.h"

namespace granary::session {
namespace {

TEST(FileChecksum, is_that_of_the_bytes_over_any_number_of_blocks) {
  const test::ScratchDirectory scratch;
  for (std::size_t size : {std::size_t{0}, std::size_t{1} << 20, (std::size_t{3} << 20) + 1}) {
    const std::string text(size, 'x');
    EXPECT_EQ(*sha256_of_file(scratch.write("f", text)), sha256_hex(text)) << size;
  }
  EXPECT_EQ(sha256_of_file(scratch.file("none")).error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace granary::session
