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
      share_(c,
             "INSERT OR REPLACE INTO result (job, message) SELECT ?2, message FROM result WHERE "
             "job = ?1"),
      share_values_(
          c,
          "INSERT OR REPLACE INTO job_value (job, name, value, error, unit, error_basis) "
          "SELECT ?2, name, value, error, unit, error_basis FROM job_value WHERE job = ?1") {}

void ValueTable::put(JobId job, const v1::Result& result) {
  const std::string bytes = result.SerializeAsString();
  Use row(put_);
  row->bind(1, job);
  row->bindNoCopy(2, bytes.data(), static_cast<int>(bytes.size()));
  row->exec();
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
  }
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
  for (SQLite::Statement* statement : {&share_, &share_values_}) {
    Use row(*statement);
    row->bind(1, from);
    row->bind(2, to);
    row->exec();
  }
}

}  // namespace granary::server
