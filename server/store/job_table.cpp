#include "server/store/job_table.h"

#include "server/store/statement_use.h"

namespace granary::server {
namespace {

constexpr std::int64_t kPriorityMs = 600'000;

const std::string kColumns =
    "id, kind, state, priority, owner, key, filling_key, submitted_ms, started_ms, ended_ms, attempts, "
    "lost_workers, engine_crashes, task, cancel_requested, worker, error, timed_out, reused, "
    "time_limit_s, result_sha256, result_bytes, study, needs";

JobRecord read_job(SQLite::Statement& row) {
  JobRecord job;
  int i = 0;
  job.id = row.getColumn(i++).getInt64();
  job.kind = row.getColumn(i++).getString();
  job.state = static_cast<v1::JobState>(row.getColumn(i++).getInt());
  job.priority = row.getColumn(i++).getInt();
  job.owner = row.getColumn(i++).getString();
  job.key = row.getColumn(i++).getString();
  job.filling_key = row.getColumn(i++).getString();
  job.submitted_ms = row.getColumn(i++).getInt64();
  job.started_ms = row.getColumn(i++).getInt64();
  job.ended_ms = row.getColumn(i++).getInt64();
  job.attempts = row.getColumn(i++).getUInt();
  job.lost_workers = row.getColumn(i++).getUInt();
  job.engine_crashes = row.getColumn(i++).getUInt();
  job.task = row.getColumn(i++).getInt64();
  job.cancel_requested = row.getColumn(i++).getInt() != 0;
  job.worker = row.getColumn(i++).getString();
  job.error = row.getColumn(i++).getString();
  job.timed_out = row.getColumn(i++).getInt() != 0;
  job.reused = row.getColumn(i++).getInt() != 0;
  job.time_limit_s = row.getColumn(i++).getDouble();
  job.result_sha256 = row.getColumn(i++).getString();
  job.result_bytes = static_cast<std::uint64_t>(row.getColumn(i++).getInt64());
  job.study = row.getColumn(i++).getInt64();
  job.needs = row.getColumn(i++).getString();
  if (row.getColumnCount() > i) {
    job.scene_bytes = row.getColumn(i++).getString();
    job.resolved_bytes = row.getColumn(i++).getString();
  }
  return job;
}

}  // namespace

JobTable::JobTable(SQLite::Database& c)
    : connection_(c),
      insert_(c,
              "INSERT INTO job (kind, state, rank, priority, owner, key, scene, resolved, "
              "submitted_ms, time_limit_s, filling_key, study, needs) "
              "VALUES (?, 1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      insert_tag_(c, "INSERT INTO job_tag (job, name, value) VALUES (?, ?, ?)"),
      find_(c, "SELECT " + kColumns + ", scene, resolved FROM job WHERE id = ?"),
      update_(
          c,
          "UPDATE job SET state = ?, started_ms = ?, ended_ms = ?, attempts = ?, lost_workers = ?, "
          "engine_crashes = ?, task = ?, cancel_requested = ?, worker = ?, error = ?, timed_out = "
          "?, "
          "reused = ?, result_sha256 = ?, result_bytes = ? WHERE id = ?"),
      erase_(c, "DELETE FROM job WHERE id = ?"),
      waiting_(c,
               "SELECT rank, id FROM job WHERE state = 1 AND kind = ? AND needs = ? "
               "ORDER BY rank, id LIMIT 1"),
      complete_(
          c, "SELECT " + kColumns + " FROM job WHERE state = 3 AND key = ? AND reused = 0 LIMIT 1"),
      tags_(c, "SELECT name, value FROM job_tag WHERE job = ?") {}

JobId JobTable::insert(const NewJob& job, std::int64_t submitted_ms) {
  Use row(insert_);
  row->bind(1, job.kind);
  row->bind(2, submitted_ms - kPriorityMs * job.priority);
  row->bind(3, job.priority);
  row->bind(4, job.owner);
  row->bind(5, job.key);
  row->bindNoCopy(6, job.scene_bytes.data(), static_cast<int>(job.scene_bytes.size()));
  row->bindNoCopy(7, job.resolved_bytes.data(), static_cast<int>(job.resolved_bytes.size()));
  row->bind(8, submitted_ms);
  row->bind(9, job.time_limit_s);
  row->bind(10, job.filling_key);
  row->bind(11, job.study);
  row->bind(12, job.needs);
  row->exec();
  const JobId id = connection_.getLastInsertRowid();
  for (const auto& [name, value] : job.tags) {
    Use tag(insert_tag_);
    tag->bind(1, id);
    tag->bind(2, name);
    tag->bind(3, value);
    tag->exec();
  }
  return id;
}

std::optional<JobRecord> JobTable::one(SQLite::Statement& statement, bool with_tags) {
  if (!statement.executeStep()) return {};
  JobRecord job = read_job(statement);
  if (with_tags) read_tags(job);
  return job;
}

void JobTable::read_tags(JobRecord& job) {
  Use tag(tags_);
  tag->bind(1, job.id);
  while (tag->executeStep())
    job.tags[tag->getColumn(0).getString()] = tag->getColumn(1).getString();
}

std::optional<JobRecord> JobTable::find(JobId id) {
  Use row(find_);
  row->bind(1, id);
  return one(find_, true);
}

// One look into the index per class, however many jobs of other classes wait before it.
std::optional<JobRecord> JobTable::next_waiting(const std::vector<QueueClass>& classes) {
  std::optional<std::pair<std::int64_t, JobId>> first;
  for (const QueueClass& each : classes) {
    Use row(waiting_);
    row->bind(1, each.kind);
    row->bind(2, each.needs);
    if (!row->executeStep()) continue;
    const std::pair<std::int64_t, JobId> found{row->getColumn(0).getInt64(), row->getColumn(1).getInt64()};
    if (!first || found < *first) first = found;
  }
  if (!first) return {};
  return find(first->second);
}

std::optional<JobRecord> JobTable::find_complete(const std::string& key) {
  Use row(complete_);
  row->bind(1, key);
  return one(complete_, false);
}

void JobTable::update(const JobRecord& job) {
  Use row(update_);
  int i = 1;
  row->bind(i++, static_cast<int>(job.state));
  row->bind(i++, job.started_ms);
  row->bind(i++, job.ended_ms);
  row->bind(i++, job.attempts);
  row->bind(i++, job.lost_workers);
  row->bind(i++, job.engine_crashes);
  row->bind(i++, job.task);
  row->bind(i++, job.cancel_requested ? 1 : 0);
  row->bind(i++, job.worker);
  row->bind(i++, job.error);
  row->bind(i++, job.timed_out ? 1 : 0);
  row->bind(i++, job.reused ? 1 : 0);
  row->bind(i++, job.result_sha256);
  row->bind(i++, static_cast<std::int64_t>(job.result_bytes));
  row->bind(i++, job.id);
  row->exec();
}

void JobTable::erase(JobId id) {
  Use row(erase_);
  row->bind(1, id);
  row->exec();
}

std::vector<JobRecord> JobTable::list(const ListFilter& filter) {
  std::string sql = "SELECT " + kColumns + " FROM job WHERE 1";
  if (filter.before > 0) sql += " AND id < :before";
  if (filter.state) sql += " AND state = :state";
  if (!filter.kind.empty()) sql += " AND kind = :kind";
  for (std::size_t i = 0; i < filter.tags.size(); ++i)
    sql += " AND EXISTS (SELECT 1 FROM job_tag WHERE job = job.id AND name = :n" +
           std::to_string(i) + " AND value = :v" + std::to_string(i) + ")";
  SQLite::Statement row(connection_, sql + " ORDER BY id DESC LIMIT :limit");
  if (filter.before > 0) row.bind(":before", filter.before);
  if (filter.state) row.bind(":state", static_cast<int>(*filter.state));
  if (!filter.kind.empty()) row.bind(":kind", filter.kind);
  std::size_t i = 0;
  for (const auto& [name, value] : filter.tags) {
    row.bind(":n" + std::to_string(i), name);
    row.bind(":v" + std::to_string(i++), value);
  }
  row.bind(":limit", filter.limit);
  std::vector<JobRecord> jobs;
  while (row.executeStep()) jobs.push_back(read_job(row));
  for (JobRecord& job : jobs) read_tags(job);
  return jobs;
}

std::vector<JobAge> JobTable::ages_after(JobId after, std::uint32_t limit) {
  SQLite::Statement row(
      connection_,
      "SELECT id, submitted_ms, ended_ms, state IN (3, 4, 5, 6) "
      "AND NOT EXISTS (SELECT 1 FROM job_tag WHERE job = job.id AND name = 'keep') "
      "AND NOT EXISTS (SELECT 1 FROM study WHERE study.id = job.study AND study.ended_ms = 0) "
      "FROM job WHERE id > ? ORDER BY id LIMIT ?");
  row.bind(1, after);
  row.bind(2, limit);
  std::vector<JobAge> ages;
  while (row.executeStep())
    ages.push_back({row.getColumn(0).getInt64(), row.getColumn(1).getInt64(),
                    row.getColumn(2).getInt64(), row.getColumn(3).getInt() != 0});
  return ages;
}

std::map<std::string, std::uint64_t> JobTable::waiting_by_owner() {
  SQLite::Statement row(connection_, "SELECT owner, count(*) FROM job WHERE state = 1 GROUP BY owner");
  std::map<std::string, std::uint64_t> counts;
  while (row.executeStep())
    counts[row.getColumn(0).getString()] = static_cast<std::uint64_t>(row.getColumn(1).getInt64());
  return counts;
}

std::map<QueueClass, std::uint64_t> JobTable::waiting_by_class() {
  SQLite::Statement row(connection_, "SELECT kind, needs, count(*) FROM job WHERE state = 1 GROUP BY kind, needs");
  std::map<QueueClass, std::uint64_t> counts;
  while (row.executeStep())
    counts[{row.getColumn(0).getString(), row.getColumn(1).getString()}] =
        static_cast<std::uint64_t>(row.getColumn(2).getInt64());
  return counts;
}

std::uint64_t JobTable::count_running() {
  return static_cast<std::uint64_t>(
      connection_.execAndGet("SELECT count(*) FROM job WHERE state = 2").getInt64());
}

}  // namespace granary::server
