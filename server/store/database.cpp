#include "server/store/database.h"

#include <sqlite3.h>

#include <stdexcept>

#include "server/store/migrations.h"

namespace granary::server {
namespace {

void check_integrity(SQLite::Database& connection) {
  SQLite::Statement check(connection, "PRAGMA quick_check(1)");
  check.executeStep();
  const std::string verdict = check.getColumn(0).getString();
  if (verdict != "ok") throw std::runtime_error("the database is damaged: " + verdict);
}

}  // namespace

Database::Database(const std::filesystem::path& file)
    : connection_(file.string(),
                  SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_NOMUTEX) {
  connection_.exec("PRAGMA journal_mode = WAL");
  connection_.exec("PRAGMA synchronous = FULL");  // a reply means the job survives a power cut
  connection_.exec("PRAGMA foreign_keys = ON");
  connection_.exec("PRAGMA cache_size = -32768");
  connection_.setBusyTimeout(5000);
  check_integrity(connection_);
  migrate(connection_);
}

bool Database::in_transaction() const {
  return sqlite3_get_autocommit(connection_.getHandle()) == 0;
}

void Database::rollback() {
  if (in_transaction()) connection_.exec("ROLLBACK");
}

ErrorCode Database::code_of(const std::exception& failure) const {
  const auto* error = dynamic_cast<const SQLite::Exception*>(&failure);
  return error && error->getErrorCode() == SQLITE_FULL ? ErrorCode::resource_exhausted
                                                       : ErrorCode::unavailable;
}

}  // namespace granary::server
