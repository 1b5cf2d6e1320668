// The SQLite file: opened by this process only (a lock file beside it says so), WAL, every commit
// fsynced, migrated to the present schema. SQLiteCpp does not appear outside server/store.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>

#include "server/store/owner_thread.h"

namespace granary::server {

class Database : public TransactionControl {
 public:
  // Throws std::runtime_error: file damaged, written by a newer server, or not writable.
  explicit Database(const std::filesystem::path& file);

  void begin() override { connection_.exec("BEGIN"); }
  void commit() override { connection_.exec("COMMIT"); }
  void rollback() override;
  void savepoint() override { connection_.exec("SAVEPOINT request"); }
  void release_savepoint() override { connection_.exec("RELEASE request"); }
  void rollback_to_savepoint() override {
    connection_.exec("ROLLBACK TO request; RELEASE request");
  }
  bool in_transaction() const override;
  ErrorCode code_of(const std::exception& failure) const override;

  SQLite::Database& connection() { return connection_; }

 private:
  SQLite::Database connection_;
};

}  // namespace granary::server
