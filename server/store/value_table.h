// Tables result (the whole message), job_value (one row per value), job_cost, value_name (every value
// ever seen, by kind) and job_series: what the views of the query door stand on.
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
  void put_series(JobId job, const v1::SeriesList& series);

 private:
  void put_values(JobId job, const v1::Result& result);
  void put_cost(JobId job, const v1::Result& result);

  SQLite::Statement put_, find_, clear_, put_value_, put_name_, put_cost_, put_series_;
  SQLite::Statement share_, share_values_, share_cost_, share_series_;
};

}  // namespace granary::server
