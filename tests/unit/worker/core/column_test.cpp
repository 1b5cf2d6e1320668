#include "worker/core/column.h"

#include <gtest/gtest.h>

namespace granary::core {

TEST(State, gives_back_what_was_put) {
  State state;
  state.put<double>("position", "m", {1.0, 2.0, 3.0, 4.0}, 2);
  state.put_scalar<std::uint64_t>("step", "1", 7);
  EXPECT_EQ(state.get<double>("position"), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(state.find("position")->rows, 2u);
  EXPECT_EQ(state.get_scalar<std::uint64_t>("step"), 7u);
}

TEST(State, names_the_missing_column) {
  State state;
  try {
    state.get<double>("velocity");
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("velocity"), std::string::npos);
  }
}

TEST(HashColumns, changes_with_every_bit_and_with_the_shape) {
  auto column = make_column<double>("x", "m", std::vector<double>{1, 2, 3, 4});
  auto hash = [](const Column& c) {
    ColumnView views[] = {view_of(c)};
    return hash_columns(views);
  };
  const std::string before = hash(column);
  EXPECT_EQ(before.size(), 32u);
  Column reshaped = column;
  reshaped.rows = 2;
  reshaped.width = 2;
  EXPECT_NE(hash(reshaped), before);
  column.bytes[9] ^= std::byte{1};
  EXPECT_NE(hash(column), before);
}

}  // namespace granary::core
