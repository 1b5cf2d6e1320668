#include "server/store/migrations.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"

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

// Every schema that was ever released: made by its own migrations, filled, opened by today's server.
TEST(Migrations, bring_a_filled_database_of_every_earlier_schema_here) {
  for (int schema = 1; schema < newest_schema(); ++schema) {
    const auto file = fresh_file("earlier.db");
    {
      SQLite::Database earlier(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
      migrate_to(earlier, schema);
      earlier.exec("INSERT INTO job (kind, state, rank, priority, owner, key, scene, resolved, submitted_ms) "
                   "VALUES ('discharge', 1, 5, 0, 'anna', 'k', x'', x'', 5), "
                   "('chute', 3, 6, 0, 'anna', 'done', x'', x'', 6)");
      earlier.exec("INSERT INTO job_value VALUES (2, 'exit_speed_m_per_s', 2.5, NULL, 'm/s', 'one run')");
    }
    Database now(file);
    SqliteJobStore store(now.connection());
    const auto waiting = store.next_waiting({{"discharge", ""}});
    ASSERT_TRUE(waiting.has_value()) << "schema " << schema;
    EXPECT_EQ(waiting->id, 1);
    EXPECT_EQ(waiting->owner, "anna");
    EXPECT_TRUE(store.find_complete("done").has_value()) << "schema " << schema;
    EXPECT_EQ(now.connection().execAndGet("PRAGMA user_version").getInt(), newest_schema());
    EXPECT_EQ(now.connection().execAndGet("SELECT value FROM job_value").getDouble(), 2.5);
  }
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
