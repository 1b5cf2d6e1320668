// Table worker: the last thing known of every worker that ever connected.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "server/jobs/records.h"

namespace granary::server {

class WorkerTable {
 public:
  explicit WorkerTable(SQLite::Database& connection);

  void put(const WorkerRecord& worker);
  void mark_all_lost();

 private:
  SQLite::Statement put_, mark_lost_;
};

}  // namespace granary::server
