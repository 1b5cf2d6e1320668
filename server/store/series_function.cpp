#include "server/store/series_function.h"

#include <sqlite3.h>

#include <new>
#include <stdexcept>
#include <string>

#include "granary/v1/result.pb.h"

namespace granary::server {
namespace {

enum Column { kName, kTime, kValue, kMessage };

// SQLite's structures come first, so that its pointers are pointers to ours.
struct SeriesTable {
  sqlite3_vtab base{};
};

struct SeriesCursor {
  sqlite3_vtab_cursor base{};
  v1::SeriesList list;
  int series = 0, column = 0, row = 0;
  sqlite3_int64 position = 0;

  bool ended() const { return series >= list.series_size(); }
  const v1::Series& at() const { return list.series(series); }
  int rows() const {
    if (at().columns_size() == 0) return 0;
    return std::min(at().time_s_size(), at().columns(column).values_size());
  }
  // To the next row that exists.
  void settle() {
    while (!ended() && row >= rows()) {
      row = 0;
      if (++column < at().columns_size()) continue;
      column = 0;
      ++series;
    }
  }
};

int connect(sqlite3* connection, void*, int, const char* const*, sqlite3_vtab** table, char**) {
  const int status = sqlite3_declare_vtab(
      connection, "CREATE TABLE x(name TEXT, time_s REAL, value REAL, message HIDDEN)");
  if (status != SQLITE_OK) return status;
  sqlite3_vtab_config(connection, SQLITE_VTAB_INNOCUOUS);
  auto* made = new (std::nothrow) SeriesTable;
  *table = reinterpret_cast<sqlite3_vtab*>(made);
  return made ? SQLITE_OK : SQLITE_NOMEM;
}

int disconnect(sqlite3_vtab* table) {
  delete reinterpret_cast<SeriesTable*>(table);
  return SQLITE_OK;
}

// Only one plan: the message is given as an argument.
int best_index(sqlite3_vtab*, sqlite3_index_info* info) {
  for (int i = 0; i < info->nConstraint; ++i) {
    const auto& constraint = info->aConstraint[i];
    if (constraint.iColumn != kMessage || constraint.op != SQLITE_INDEX_CONSTRAINT_EQ) continue;
    if (!constraint.usable) return SQLITE_CONSTRAINT;
    info->aConstraintUsage[i].argvIndex = 1;
    info->aConstraintUsage[i].omit = 1;
    info->estimatedCost = 1000;
    info->estimatedRows = 1000;
    return SQLITE_OK;
  }
  return SQLITE_CONSTRAINT;
}

int open(sqlite3_vtab*, sqlite3_vtab_cursor** cursor) {
  auto* made = new (std::nothrow) SeriesCursor;
  *cursor = reinterpret_cast<sqlite3_vtab_cursor*>(made);
  return made ? SQLITE_OK : SQLITE_NOMEM;
}

SeriesCursor& ours(sqlite3_vtab_cursor* cursor) {
  return *reinterpret_cast<SeriesCursor*>(cursor);
}

int close(sqlite3_vtab_cursor* cursor) {
  delete &ours(cursor);
  return SQLITE_OK;
}

int filter(sqlite3_vtab_cursor* base, int, const char*, int, sqlite3_value** arguments) {
  SeriesCursor& cursor = ours(base);
  cursor.list.Clear();
  cursor.series = cursor.column = cursor.row = 0;
  cursor.position = 0;
  const void* bytes = sqlite3_value_blob(arguments[0]);
  if (bytes != nullptr) cursor.list.ParseFromArray(bytes, sqlite3_value_bytes(arguments[0]));
  cursor.settle();
  return SQLITE_OK;
}

int next(sqlite3_vtab_cursor* base) {
  SeriesCursor& cursor = ours(base);
  ++cursor.row;
  ++cursor.position;
  cursor.settle();
  return SQLITE_OK;
}

int at_end(sqlite3_vtab_cursor* base) {
  return ours(base).ended();
}

int column(sqlite3_vtab_cursor* base, sqlite3_context* context, int index) {
  const SeriesCursor& cursor = ours(base);
  const v1::Series& series = cursor.at();
  const v1::Series::Column& values = series.columns(cursor.column);
  if (index == kName) {
    const std::string name = series.name() + "." + values.name();
    sqlite3_result_text(context, name.data(), static_cast<int>(name.size()), SQLITE_TRANSIENT);
  } else if (index == kTime) {
    sqlite3_result_double(context, series.time_s(cursor.row));
  } else if (index == kValue) {
    sqlite3_result_double(context, values.values(cursor.row));  // NaN becomes NULL
  }
  return SQLITE_OK;
}

int row_id(sqlite3_vtab_cursor* base, sqlite3_int64* id) {
  *id = ours(base).position;
  return SQLITE_OK;
}

sqlite3_module make_module() {
  sqlite3_module module{};
  module.xConnect = connect;  // no xCreate: it exists as a function only
  module.xBestIndex = best_index;
  module.xDisconnect = disconnect;
  module.xOpen = open;
  module.xClose = close;
  module.xFilter = filter;
  module.xNext = next;
  module.xEof = at_end;
  module.xColumn = column;
  module.xRowid = row_id;
  return module;
}

}  // namespace

void add_series_function(sqlite3* connection) {
  static const sqlite3_module module = make_module();
  if (sqlite3_create_module(connection, "series_rows", &module, nullptr) != SQLITE_OK)
    throw std::runtime_error(sqlite3_errmsg(connection));
}

}  // namespace granary::server
