#include "worker/storage/column_codec.h"

#include <gtest/gtest.h>

#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

core::State sample_state() {
  core::State state;
  state.put("position_m", "m", std::vector<double>{1, 2, 3, 4}, 2);
  state.put("id", "1", std::vector<std::int64_t>{-1, 7});
  state.put("empty", "J", std::vector<float>{});
  state.put_scalar("flag", "1", std::uint8_t{255});
  return state;
}

TEST(ColumnCodec, gives_back_names_units_shapes_and_bytes) {
  Bytes bytes;
  encode_state(bytes, sample_state());
  ByteReader reader(bytes);
  const core::State back{decode_columns(reader)};
  EXPECT_EQ(back.get<double>("position_m"), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(back.find("position_m")->width, 2u);
  EXPECT_EQ(back.find("position_m")->rows, 2u);
  EXPECT_EQ(back.find("position_m")->unit, "m");
  EXPECT_EQ(back.get<std::int64_t>("id"), (std::vector<std::int64_t>{-1, 7}));
  EXPECT_TRUE(back.get<float>("empty").empty());
  EXPECT_EQ(back.get_scalar<std::uint8_t>("flag"), 255);
}

TEST(ColumnCodec, refuses_every_truncation) {
  Bytes bytes;
  encode_state(bytes, sample_state());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ByteReader reader(std::span<const std::byte>(bytes).first(length));
    EXPECT_THROW(decode_columns(reader), StorageError) << "cut at " << length;
  }
}

TEST(ColumnCodec, refuses_a_shape_whose_size_overflows) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put(std::uint32_t{1});
  writer.put_text("x");
  writer.put_text("m");
  writer.put(static_cast<std::uint8_t>(core::ElementType::f64));
  writer.put(std::uint64_t{1} << 61);  // times 8 bytes = 2^64 = 0
  writer.put(std::uint64_t{1});
  ByteReader reader(bytes);
  EXPECT_THROW(decode_columns(reader), StorageError);
}

}  // namespace
}  // namespace granary::storage
