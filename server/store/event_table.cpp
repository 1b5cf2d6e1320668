#include "server/store/event_table.h"

#include "server/store/statement_use.h"

namespace granary::server {

EventTable::EventTable(SQLite::Database& c)
    : insert_(
          c,
          "INSERT INTO job_event (job, sequence, time_ms, state, message) VALUES (?, ?, ?, ?, ?)"),
      after_(
          c,
          "SELECT sequence, time_ms, state, message FROM job_event WHERE job = ? AND sequence > ? "
          "ORDER BY sequence"),
      insert_log_(c,
                  "INSERT INTO job_log (job, line, text) VALUES (?1, "
                  "(SELECT coalesce(max(line), 0) + 1 FROM job_log WHERE job = ?1), ?2)"),
      logs_(c, "SELECT text FROM job_log WHERE job = ? ORDER BY line") {}

void EventTable::append(JobId job, const EventRecord& event) {
  Use row(insert_);
  row->bind(1, job);
  row->bind(2, static_cast<std::int64_t>(event.sequence));
  row->bind(3, event.time_ms);
  row->bind(4, static_cast<int>(event.state));
  row->bind(5, event.message);
  row->exec();
}

std::vector<EventRecord> EventTable::after(JobId job, std::uint64_t sequence) {
  Use row(after_);
  row->bind(1, job);
  row->bind(2, static_cast<std::int64_t>(sequence));
  std::vector<EventRecord> events;
  while (row->executeStep())
    events.push_back(
        {static_cast<std::uint64_t>(row->getColumn(0).getInt64()), row->getColumn(1).getInt64(),
         static_cast<v1::JobState>(row->getColumn(2).getInt()), row->getColumn(3).getString()});
  return events;
}

void EventTable::append_logs(JobId job, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    Use row(insert_log_);
    row->bind(1, job);
    row->bind(2, line);
    row->exec();
  }
}

std::vector<std::string> EventTable::logs(JobId job) {
  Use row(logs_);
  row->bind(1, job);
  std::vector<std::string> lines;
  while (row->executeStep()) lines.push_back(row->getColumn(0).getString());
  return lines;
}

}  // namespace granary::server
