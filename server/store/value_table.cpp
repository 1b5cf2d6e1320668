#include "server/store/value_table.h"

#include <string>

#include "server/store/statement_use.h"

namespace granary::server {

ValueTable::ValueTable(SQLite::Database& c)
    : put_(c, "INSERT OR REPLACE INTO result (job, message) VALUES (?, ?)"),
      find_(c, "SELECT message FROM result WHERE job = ?"),
      clear_(c, "DELETE FROM job_value WHERE job = ?"),
      put_value_(c,
                 "INSERT INTO job_value (job, name, value, error, unit, error_basis) VALUES (?, ?, "
                 "?, ?, ?, ?)"),
      put_name_(c, "INSERT OR IGNORE INTO value_name (kind, name, unit) VALUES (?, ?, ?)"),
      put_cost_(c,
                "INSERT OR REPLACE INTO job_cost (job, wall_s, cpu_s, reused_s, steps, "
                "particle_steps, ns_per_particle_step, contacts_per_particle, threads, "
                "peak_rss_bytes, remainder_ratio) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      put_series_(c, "INSERT OR REPLACE INTO job_series (job, message) VALUES (?, ?)"),
      share_(c,
             "INSERT OR REPLACE INTO result (job, message) SELECT ?2, message FROM result WHERE "
             "job = ?1"),
      share_values_(
          c,
          "INSERT OR REPLACE INTO job_value (job, name, value, error, unit, error_basis) "
          "SELECT ?2, name, value, error, unit, error_basis FROM job_value WHERE job = ?1"),
      share_cost_(c,
                  "INSERT OR REPLACE INTO job_cost SELECT ?2, wall_s, cpu_s, reused_s, steps, "
                  "particle_steps, ns_per_particle_step, contacts_per_particle, threads, "
                  "peak_rss_bytes, remainder_ratio FROM job_cost WHERE job = ?1"),
      share_series_(c,
                    "INSERT OR REPLACE INTO job_series (job, message) SELECT ?2, message FROM "
                    "job_series WHERE job = ?1") {}

void ValueTable::put(JobId job, const v1::Result& result) {
  const std::string bytes = result.SerializeAsString();
  Use row(put_);
  row->bind(1, job);
  row->bindNoCopy(2, bytes.data(), static_cast<int>(bytes.size()));
  row->exec();
  put_values(job, result);
  put_cost(job, result);
}

void ValueTable::put_values(JobId job, const v1::Result& result) {
  Use clear(clear_);
  clear->bind(1, job);
  clear->exec();
  for (const auto& [name, quantity] : result.values()) {
    Use value(put_value_);
    value->bind(1, job);
    value->bind(2, name);
    if (quantity.has_value()) value->bind(3, quantity.value());
    if (quantity.has_error()) value->bind(4, quantity.error());
    value->bind(5, quantity.unit());
    value->bind(6, quantity.error_basis());
    value->exec();
    Use known(put_name_);
    known->bind(1, result.kind());
    known->bind(2, name);
    known->bind(3, quantity.unit());
    known->exec();
  }
}

void ValueTable::put_cost(JobId job, const v1::Result& result) {
  const v1::Cost& cost = result.cost();
  Use row(put_cost_);
  int i = 1;
  row->bind(i++, job);
  row->bind(i++, cost.wall_s());
  row->bind(i++, cost.cpu_s());
  row->bind(i++, cost.reused_s());
  row->bind(i++, static_cast<std::int64_t>(cost.steps()));
  row->bind(i++, static_cast<std::int64_t>(cost.particle_steps()));
  row->bind(i++, cost.ns_per_particle_step());
  row->bind(i++, cost.contacts_per_particle());
  row->bind(i++, cost.threads());
  row->bind(i++, static_cast<std::int64_t>(cost.peak_rss_bytes()));
  row->bind(i++, result.ledger().remainder_ratio());
  row->exec();
}

// Kept as the worker's message holds it: a blob a job takes a tenth of the room of a row a sample.
void ValueTable::put_series(JobId job, const v1::SeriesList& series) {
  if (series.series().empty()) return;
  const std::string bytes = series.SerializeAsString();
  Use row(put_series_);
  row->bind(1, job);
  row->bindNoCopy(2, bytes.data(), static_cast<int>(bytes.size()));
  row->exec();
}

std::optional<v1::Result> ValueTable::find(JobId job) {
  Use row(find_);
  row->bind(1, job);
  if (!row->executeStep()) return {};
  v1::Result result;
  result.ParseFromString(row->getColumn(0).getString());
  return result;
}

void ValueTable::share(JobId from, JobId to) {
  for (SQLite::Statement* statement : {&share_, &share_values_, &share_cost_, &share_series_}) {
    Use row(*statement);
    row->bind(1, from);
    row->bind(2, to);
    row->exec();
  }
}

}  // namespace granary::server
