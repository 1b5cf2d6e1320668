// Tables job_event (durable state changes, by sequence) and job_log (what the worker said).
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <string>
#include <vector>

#include "server/jobs/records.h"

namespace granary::server {

class EventTable {
 public:
  explicit EventTable(SQLite::Database& connection);

  void append(JobId job, const EventRecord& event);
  std::vector<EventRecord> after(JobId job, std::uint64_t sequence);
  void append_logs(JobId job, const std::vector<std::string>& lines);
  std::vector<std::string> logs(JobId job);

 private:
  SQLite::Statement insert_, after_, insert_log_, logs_;
};

}  // namespace granary::server
