#include "server/store/task_table.h"

#include "server/store/statement_use.h"

namespace granary::server {

TaskTable::TaskTable(SQLite::Database& c)
    : connection_(c),
      insert_(c, "INSERT INTO task (job, worker, started_ms) VALUES (?, ?, ?)"),
      end_(c, "UPDATE task SET ended_ms = ?, outcome = ?, message = ? WHERE id = ?"),
      open_(c, "SELECT id, job, worker, started_ms FROM task WHERE ended_ms = 0 ORDER BY id") {}

TaskId TaskTable::insert(JobId job, const std::string& worker, std::int64_t started_ms) {
  Use row(insert_);
  row->bind(1, job);
  row->bind(2, worker);
  row->bind(3, started_ms);
  row->exec();
  return connection_.getLastInsertRowid();
}

void TaskTable::end(TaskId task, std::int64_t ended_ms, std::string_view outcome,
                    std::string_view message) {
  Use row(end_);
  row->bind(1, ended_ms);
  row->bind(2, std::string(outcome));
  row->bind(3, std::string(message));
  row->bind(4, task);
  row->exec();
}

std::vector<TaskRecord> TaskTable::open() {
  Use row(open_);
  std::vector<TaskRecord> tasks;
  while (row->executeStep())
    tasks.push_back({row->getColumn(0).getInt64(), row->getColumn(1).getInt64(),
                     row->getColumn(2).getString(), row->getColumn(3).getInt64()});
  return tasks;
}

}  // namespace granary::server
