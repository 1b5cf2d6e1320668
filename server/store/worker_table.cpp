#include "server/store/worker_table.h"

#include "server/store/statement_use.h"

namespace granary::server {

WorkerTable::WorkerTable(SQLite::Database& c)
    : put_(c,
           "INSERT INTO worker (id, host, pid, slots, state, engine_version, vector_path, "
           "first_seen_ms, seen_ms) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?8) "
           "ON CONFLICT (id) DO UPDATE SET host = ?2, pid = ?3, slots = ?4, state = ?5, "
           "engine_version = ?6, vector_path = ?7, seen_ms = ?8"),
      mark_lost_(c, "UPDATE worker SET state = 'lost'") {}

void WorkerTable::put(const WorkerRecord& worker) {
  Use row(put_);
  row->bind(1, worker.id);
  row->bind(2, worker.host);
  row->bind(3, worker.pid);
  row->bind(4, worker.slots);
  row->bind(5, worker.state);
  row->bind(6, worker.engine_version);
  row->bind(7, worker.vector_path);
  row->bind(8, worker.seen_ms);
  row->exec();
}

void WorkerTable::mark_all_lost() {
  Use row(mark_lost_);
  row->exec();
}

}  // namespace granary::server
