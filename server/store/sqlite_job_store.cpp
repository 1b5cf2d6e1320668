#include "server/store/sqlite_job_store.h"

#include "server/store/statement_use.h"

namespace granary::server {

SqliteJobStore::SqliteJobStore(SQLite::Database& c)
    : connection_(c),
      jobs_(c),
      tasks_(c),
      values_(c),
      events_(c),
      resume_(c),
      workers_(c),
      find_request_(c, "SELECT first_job, job_count FROM request WHERE id = ?"),
      put_request_(
          c, "INSERT INTO request (id, first_job, job_count, created_ms) VALUES (?, ?, ?, ?)") {}

// A submission is one transaction, so its job ids are consecutive.
std::optional<std::vector<JobId>> SqliteJobStore::find_request(const std::string& request_id) {
  Use row(find_request_);
  row->bind(1, request_id);
  if (!row->executeStep()) return {};
  std::vector<JobId> jobs(static_cast<std::size_t>(row->getColumn(1).getInt64()));
  JobId next = row->getColumn(0).getInt64();
  for (JobId& job : jobs) job = next++;
  return jobs;
}

void SqliteJobStore::put_request(const std::string& request_id, const std::vector<JobId>& jobs,
                                 std::int64_t now_ms) {
  Use row(put_request_);
  row->bind(1, request_id);
  row->bind(2, jobs.empty() ? JobId{0} : jobs.front());
  row->bind(3, static_cast<std::int64_t>(jobs.size()));
  row->bind(4, now_ms);
  row->exec();
}

void SqliteJobStore::forget_before(std::int64_t wall_ms) {
  SQLite::Statement requests(connection_, "DELETE FROM request WHERE created_ms < ?");
  requests.bind(1, wall_ms);
  requests.exec();
  SQLite::Statement fillings(connection_,
                             "DELETE FROM filling WHERE created_ms < ? AND key NOT IN "
                             "(SELECT filling_key FROM job WHERE state IN (1, 2))");
  fillings.bind(1, wall_ms);
  fillings.exec();
}

std::uint64_t SqliteJobStore::next_epoch() {
  connection_.exec("INSERT INTO server_start DEFAULT VALUES");
  return static_cast<std::uint64_t>(connection_.getLastInsertRowid());
}

}  // namespace granary::server
