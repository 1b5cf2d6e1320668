#include "server/store/migrations.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "server/store/database.h"

namespace granary::server {
namespace {

std::filesystem::path fresh_file(const char* name) {
  const auto file = std::filesystem::path(testing::TempDir()) / name;
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(file.string() + suffix);
  return file;
}

TEST(Migrations, open_twice_changes_nothing) {
  const auto file = fresh_file("migrate.db");
  { Database first(file); }
  Database second(file);
  EXPECT_EQ(second.connection().execAndGet("PRAGMA user_version").getInt(), newest_schema());
}

TEST(Migrations, refuse_a_file_of_a_newer_server) {
  const auto file = fresh_file("newer.db");
  {
    Database first(file);
    first.connection().exec("PRAGMA user_version = 9999");
  }
  EXPECT_THROW(Database{file}, std::runtime_error);
}

TEST(Migrations, a_damaged_file_is_refused_not_repaired_silently) {
  const auto file = fresh_file("damaged.db");
  {
    Database first(file);
    for (int i = 0; i < 200; ++i)
      first.connection().exec("INSERT INTO server_start DEFAULT VALUES");
    first.connection().exec("PRAGMA wal_checkpoint(TRUNCATE)");
  }
  const auto bytes = std::filesystem::file_size(file);
  std::filesystem::resize_file(file, bytes / 2);
  EXPECT_ANY_THROW(Database{file});
}

}  // namespace
}  // namespace granary::server
