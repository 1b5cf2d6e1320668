// Tables result (the whole message) and job_value (one row per value, for SQL).
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <optional>

#include "server/jobs/records.h"

namespace granary::server {

class ValueTable {
 public:
  explicit ValueTable(SQLite::Database& connection);

  void put(JobId job, const v1::Result& result);  // replaces
  std::optional<v1::Result> find(JobId job);
  void share(JobId from, JobId to);

 private:
  SQLite::Statement put_, find_, clear_, put_value_, share_, share_values_;
};

}  // namespace granary::server
