// Table job with its tags.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/records.h"

namespace granary::server {

class JobTable {
 public:
  explicit JobTable(SQLite::Database& connection);

  JobId insert(const NewJob& job, std::int64_t submitted_ms);
  std::optional<JobRecord> find(JobId id);
  void update(const JobRecord& job);
  void erase(JobId id);
  std::vector<JobRecord> list(const ListFilter& filter);
  std::map<std::string, std::uint64_t> waiting_by_owner();
  std::uint64_t count_running();
  std::map<QueueClass, std::uint64_t> waiting_by_class();
  std::optional<JobRecord> next_waiting(const std::vector<QueueClass>& classes);
  std::vector<JobAge> ages_after(JobId after, std::uint32_t limit);
  std::optional<JobRecord> find_complete(const std::string& key);

 private:
  std::optional<JobRecord> one(SQLite::Statement& statement, bool with_tags);
  void read_tags(JobRecord& job);

  SQLite::Database& connection_;
  SQLite::Statement insert_, insert_tag_, find_, update_, erase_, waiting_, complete_, tags_;
};

}  // namespace granary::server
