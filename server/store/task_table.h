// Table task: one row per execution of a job; its id is the fencing token.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/records.h"

namespace granary::server {

class TaskTable {
 public:
  explicit TaskTable(SQLite::Database& connection);

  TaskId insert(JobId job, const std::string& worker, std::int64_t started_ms);
  void end(TaskId task, std::int64_t ended_ms, std::string_view outcome, std::string_view message);
  std::vector<TaskRecord> open();

 private:
  SQLite::Database& connection_;
  SQLite::Statement insert_, end_, open_;
};

}  // namespace granary::server
