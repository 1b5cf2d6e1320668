#include "server/store/backup.h"

#include <SQLiteCpp/SQLiteCpp.h>

#include <stdexcept>

namespace granary::server {

void copy_database(const std::filesystem::path& source, const std::filesystem::path& target) {
  {
    SQLite::Database live(source.string(), SQLite::OPEN_READONLY);
    SQLite::Statement copy(live, "VACUUM INTO ?");  // one read transaction: one moment of the queue
    copy.bind(1, target.string());
    copy.exec();
  }
  SQLite::Database made(target.string(), SQLite::OPEN_READONLY);
  const std::string verdict = made.execAndGet("PRAGMA quick_check(1)").getString();
  if (verdict != "ok") throw std::runtime_error("the copy is damaged: " + verdict);
}

}  // namespace granary::server
