#include "server/store/migrations.h"

#include <array>
#include <stdexcept>
#include <string>

namespace granary::server {
namespace {

// rank = submitted_ms - 600000 * priority: ten minutes of waiting outweigh one level of priority.
constexpr const char* kFirst = R"sql(
CREATE TABLE job (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  state INTEGER NOT NULL,
  rank INTEGER NOT NULL,
  priority INTEGER NOT NULL,
  owner TEXT NOT NULL,
  key TEXT NOT NULL,
  scene BLOB NOT NULL,
  resolved BLOB NOT NULL,
  submitted_ms INTEGER NOT NULL,
  started_ms INTEGER NOT NULL DEFAULT 0,
  ended_ms INTEGER NOT NULL DEFAULT 0,
  attempts INTEGER NOT NULL DEFAULT 0,
  lost_workers INTEGER NOT NULL DEFAULT 0,
  engine_crashes INTEGER NOT NULL DEFAULT 0,
  task INTEGER NOT NULL DEFAULT 0,
  cancel_requested INTEGER NOT NULL DEFAULT 0,
  worker TEXT NOT NULL DEFAULT '',
  error TEXT NOT NULL DEFAULT '',
  timed_out INTEGER NOT NULL DEFAULT 0,
  reused INTEGER NOT NULL DEFAULT 0,
  time_limit_s REAL NOT NULL DEFAULT 0,
  result_sha256 TEXT NOT NULL DEFAULT '',
  result_bytes INTEGER NOT NULL DEFAULT 0
);
CREATE INDEX job_queue ON job(rank, id) WHERE state = 1;
CREATE INDEX job_by_state ON job(state, id);
CREATE INDEX job_by_key ON job(key) WHERE state = 3;
CREATE INDEX job_by_artifact ON job(result_sha256) WHERE result_sha256 <> '';

CREATE TABLE job_tag (
  job INTEGER NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  value TEXT NOT NULL,
  PRIMARY KEY (job, name)
) WITHOUT ROWID;
CREATE INDEX job_tag_by_value ON job_tag(name, value, job);

CREATE TABLE task (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  job INTEGER NOT NULL,
  worker TEXT NOT NULL,
  started_ms INTEGER NOT NULL,
  ended_ms INTEGER NOT NULL DEFAULT 0,
  outcome TEXT NOT NULL DEFAULT '',
  message TEXT NOT NULL DEFAULT ''
);
CREATE INDEX task_open ON task(id) WHERE ended_ms = 0;
CREATE INDEX task_by_job ON task(job);

CREATE TABLE result (
  job INTEGER PRIMARY KEY REFERENCES job(id) ON DELETE CASCADE,
  message BLOB NOT NULL
);
CREATE TABLE job_value (
  job INTEGER NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  value REAL,
  error REAL,
  unit TEXT NOT NULL,
  error_basis TEXT NOT NULL,
  PRIMARY KEY (job, name)
) WITHOUT ROWID;

CREATE TABLE job_event (
  job INTEGER NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  sequence INTEGER NOT NULL,
  time_ms INTEGER NOT NULL,
  state INTEGER NOT NULL,
  message TEXT NOT NULL,
  PRIMARY KEY (job, sequence)
) WITHOUT ROWID;
CREATE TABLE job_log (
  job INTEGER NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  line INTEGER NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (job, line)
) WITHOUT ROWID;

CREATE TABLE request (
  id TEXT PRIMARY KEY,
  first_job INTEGER NOT NULL,
  job_count INTEGER NOT NULL,
  created_ms INTEGER NOT NULL
) WITHOUT ROWID;

CREATE TABLE server_start (epoch INTEGER PRIMARY KEY AUTOINCREMENT, started TEXT DEFAULT CURRENT_TIMESTAMP);
)sql";

// Jobs that continue on another worker, and fillings that are shared.
constexpr const char* kResume = R"sql(
ALTER TABLE job ADD COLUMN filling_key TEXT NOT NULL DEFAULT '';
CREATE TABLE resume_file (
  job INTEGER NOT NULL REFERENCES job(id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  size_bytes INTEGER NOT NULL,
  PRIMARY KEY (job, name)
) WITHOUT ROWID;
CREATE TABLE filling (
  key TEXT PRIMARY KEY,
  sha256 TEXT NOT NULL,
  size_bytes INTEGER NOT NULL,
  created_ms INTEGER NOT NULL
) WITHOUT ROWID;
)sql";

// Studies with their trials, and what the views of the query door read.
constexpr const char* kStudies = R"sql(
ALTER TABLE job ADD COLUMN study INTEGER NOT NULL DEFAULT 0;
CREATE INDEX job_by_study ON job(study) WHERE study <> 0;
CREATE TABLE study (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  state INTEGER NOT NULL,
  owner TEXT NOT NULL,
  request_id TEXT NOT NULL,
  spec BLOB NOT NULL,
  generator BLOB NOT NULL,
  submitted_ms INTEGER NOT NULL,
  ended_ms INTEGER NOT NULL DEFAULT 0,
  planned INTEGER NOT NULL DEFAULT 0,
  trials INTEGER NOT NULL DEFAULT 0,
  told INTEGER NOT NULL DEFAULT 0,
  failed INTEGER NOT NULL DEFAULT 0,
  reused INTEGER NOT NULL DEFAULT 0,
  message TEXT NOT NULL DEFAULT '',
  summary BLOB NOT NULL DEFAULT x'',
  best_trial INTEGER,
  best_objective REAL,
  best_objective_error REAL
);
CREATE UNIQUE INDEX study_by_request ON study(request_id) WHERE request_id <> '';
CREATE INDEX study_by_state ON study(state, id);
CREATE TABLE trial (
  study INTEGER NOT NULL REFERENCES study(id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  job INTEGER NOT NULL,
  label TEXT NOT NULL,
  role TEXT NOT NULL,
  candidate INTEGER NOT NULL,
  inputs TEXT NOT NULL,
  error TEXT NOT NULL DEFAULT '',
  told INTEGER NOT NULL DEFAULT 0,
  objective REAL,
  objective_error REAL,
  feasible INTEGER,
  best_objective REAL,
  pareto INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (study, number)
) WITHOUT ROWID;
CREATE INDEX trial_by_job ON trial(job);
CREATE TABLE price_point (
  study INTEGER NOT NULL REFERENCES study(id) ON DELETE CASCADE,
  job INTEGER NOT NULL,
  rung TEXT NOT NULL,
  observable TEXT NOT NULL,
  value REAL,
  error REAL,
  cpu_s REAL
);
CREATE INDEX price_point_by_study ON price_point(study);
CREATE TABLE effect_delta (
  study INTEGER NOT NULL REFERENCES study(id) ON DELETE CASCADE,
  effect TEXT NOT NULL,
  observable TEXT NOT NULL,
  delta REAL,
  error REAL,
  cpu_ratio REAL
);
CREATE INDEX effect_delta_by_study ON effect_delta(study);

-- The views name jobs as users do; these find them by that name.
CREATE INDEX job_by_name ON job('jobs/' || id);
CREATE INDEX task_by_job_name ON task('jobs/' || job);

CREATE TABLE job_cost (
  job INTEGER PRIMARY KEY REFERENCES job(id) ON DELETE CASCADE,
  wall_s REAL, cpu_s REAL, reused_s REAL, steps INTEGER, particle_steps INTEGER,
  ns_per_particle_step REAL, contacts_per_particle REAL, threads INTEGER,
  peak_rss_bytes INTEGER, remainder_ratio REAL
);
CREATE TABLE job_series (
  job INTEGER PRIMARY KEY REFERENCES job(id) ON DELETE CASCADE,
  message BLOB NOT NULL
);
CREATE INDEX job_series_by_name ON job_series('jobs/' || job);
CREATE TABLE value_name (
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  unit TEXT NOT NULL,
  PRIMARY KEY (kind, name)
) WITHOUT ROWID;
INSERT OR IGNORE INTO value_name SELECT job.kind, name, unit FROM job_value JOIN job ON job.id = job;
CREATE TABLE worker (
  id TEXT PRIMARY KEY,
  host TEXT NOT NULL,
  pid INTEGER NOT NULL,
  slots INTEGER NOT NULL,
  state TEXT NOT NULL,
  engine_version TEXT NOT NULL,
  vector_path TEXT NOT NULL,
  first_seen_ms INTEGER NOT NULL,
  seen_ms INTEGER NOT NULL
) WITHOUT ROWID;
)sql";

// One value over all jobs without reading their units and reasons.
constexpr const char* kValueIndex = R"sql(
CREATE INDEX job_value_by_name ON job_value(name, job, value, error);
)sql";

// Jobs that ask for workers with certain tags: the queue is searched class by class.
constexpr const char* kWorkerTags = R"sql(
ALTER TABLE job ADD COLUMN needs TEXT NOT NULL DEFAULT '';
DROP INDEX job_queue;
CREATE INDEX job_queue ON job(kind, needs, rank, id) WHERE state = 1;
)sql";

// The jobs of a kind without reading their scenes, which lie in the same rows.
constexpr const char* kKindIndex = R"sql(
CREATE INDEX job_by_kind ON job(kind, id);
)sql";

constexpr std::array<const char*, 6> kMigrations = {kFirst,      kResume,     kStudies,
                                                    kValueIndex, kWorkerTags, kKindIndex};

int schema_of(SQLite::Database& connection) {
  return connection.execAndGet("PRAGMA user_version").getInt();
}

}  // namespace

int newest_schema() {
  return static_cast<int>(kMigrations.size());
}

void migrate(SQLite::Database& connection) {
  const int present = schema_of(connection);
  if (present > newest_schema())
    throw std::runtime_error("the database has schema " + std::to_string(present) +
                             ", this server knows up to " + std::to_string(newest_schema()) +
                             ": use the newer granaryd");
  migrate_to(connection, newest_schema());
}

void migrate_to(SQLite::Database& connection, int schema) {
  for (int version = schema_of(connection); version < schema; ++version) {
    SQLite::Transaction transaction(connection);
    connection.exec(kMigrations[static_cast<std::size_t>(version)]);
    connection.exec("PRAGMA user_version = " + std::to_string(version + 1));
    transaction.commit();
  }
}

}  // namespace granary::server
