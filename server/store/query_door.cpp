#include "server/store/query_door.h"

#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <unordered_set>

#include "proto/contract/rule_text.h"
#include "server/store/job_functions.h"
#include "server/store/series_function.h"

namespace granary::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kInstructionsPerCheck = 1000;  // about 20 us between looks at the clock
constexpr int kMaxSqlBytes = 100'000;
constexpr int kMaxValueBytes = 32 << 20;

struct CloseConnection {
  void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
};
struct EndStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, EndStatement>;

Error refused(const std::string& why) {
  return {ErrorCode::permission_denied,
          why + ": only reading the documented views is allowed (granary query --schema)", "sql"};
}

class Door {
 public:
  Door(const std::filesystem::path& file, const std::atomic<bool>& cancelled)
      : cancelled_(cancelled) {
    sqlite3* opened = nullptr;
    const int status =
        sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
    connection_.reset(opened);
    if (status != SQLITE_OK) throw std::runtime_error(sqlite3_errmsg(opened));
    execute("PRAGMA temp_store = MEMORY; PRAGMA cache_size = -8192");
    sqlite3_busy_timeout(opened, 1000);
    job_functions_.emplace(opened);
    add_series_function(opened);
  }

  std::vector<ViewText> views() { return query_views(known_values()); }

  // After this nothing but reading the views is possible.
  void close_behind_views() {
    std::random_device random;
    char secret[40];
    std::snprintf(secret, sizeof secret, "v%08x%08x%08x_", random(), random(), random());
    for (std::vector<std::string>& row :
         texts("SELECT name FROM sqlite_schema WHERE type = 'table'"))
      hidden_.insert(std::move(row[0]));
    for (const ViewText& view : views()) create(view, secret);
    bound_resources();
    sqlite3_set_authorizer(connection_.get(), &Door::authorize, this);
  }

  Status run(const std::string& sql, const QueryLimits& limits, RowSink& sink) {
    deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(limits.time_s));
    memory_limit_ = base_memory() + kQueryMemoryBytes;
    auto statement = compile(sql);
    if (!statement) return statement.error();
    return stream(statement->get(), limits, sink);
  }

 private:
  void execute(const std::string& sql) {
    char* message = nullptr;
    if (sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, &message) == SQLITE_OK)
      return;
    const std::string what = message ? message : "sqlite";
    sqlite3_free(message);
    throw std::runtime_error(what);
  }

  // All rows of a statement of our own whose columns are texts and never NULL.
  std::vector<std::vector<std::string>> texts(const char* sql) {
    sqlite3_stmt* made = nullptr;
    if (sqlite3_prepare_v2(connection_.get(), sql, -1, &made, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(connection_.get()));
    const Statement statement(made);
    std::vector<std::vector<std::string>> rows;
    while (sqlite3_step(made) == SQLITE_ROW) {
      auto& row = rows.emplace_back();
      for (int i = 0; i < sqlite3_column_count(made); ++i)
        row.emplace_back(reinterpret_cast<const char*>(sqlite3_column_text(made, i)));
    }
    return rows;
  }

  KnownValues known_values() {
    KnownValues known;
    for (const auto& row : texts("SELECT kind, name, unit FROM value_name"))
      (row[0] == "chute" ? known.chute : known.discharge).push_back({row[1], row[2]});
    return known;
  }

  // Two layers: a user may give a subquery any name, and the authorizer hears that name as the
  // reader of its tables; so tables are opened to the inner view alone, whose name nobody can
  // guess.
  void create(const ViewText& view, const std::string& secret) {
    std::string names, expressions;
    for (const ViewColumnText& column : view.columns) {
      names += (names.empty() ? "\"" : ", \"") + column.name + "\"";
      expressions += (expressions.empty() ? "" : ", ") + column.expression;
    }
    const std::string inner = secret + view.name;
    execute("CREATE TEMP VIEW " + inner + "(" + names + ") AS SELECT " + expressions + " FROM " +
            view.from + "; CREATE TEMP VIEW " + view.name + " AS SELECT * FROM " + inner);
    inner_.insert(inner);
    hidden_.erase(view.from.substr(0, view.from.find(' ')));
    outer_.insert(view.name);
  }

  void bound_resources() {
    sqlite3* c = connection_.get();
    sqlite3_db_config(c, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(c, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);  // "typo" is an error, not a text
    sqlite3_db_config(c, SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0, nullptr);
    sqlite3_limit(c, SQLITE_LIMIT_LENGTH, kMaxValueBytes);
    sqlite3_limit(c, SQLITE_LIMIT_SQL_LENGTH, kMaxSqlBytes);
    sqlite3_limit(c, SQLITE_LIMIT_EXPR_DEPTH, 200);
    sqlite3_limit(c, SQLITE_LIMIT_COMPOUND_SELECT, 50);
    sqlite3_limit(c, SQLITE_LIMIT_ATTACHED, 0);
    sqlite3_limit(c, SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 200);
    sqlite3_limit(c, SQLITE_LIMIT_WORKER_THREADS, 0);
    sqlite3_progress_handler(c, kInstructionsPerCheck, &Door::look_at_limits, this);
    execute("PRAGMA query_only = ON");
  }

  static int authorize(void* self, int action, const char* what, const char* detail, const char*,
                       const char* reader) {
    Door& door = *static_cast<Door*>(self);
    if (door.job_functions_->reading()) return SQLITE_OK;
    const bool allowed =
        door.may(action, what ? what : "", detail ? detail : "", reader ? reader : "");
    door.denied_ = door.denied_ || !allowed;
    return allowed ? SQLITE_OK : SQLITE_DENY;
  }

  bool may(int action, const std::string& what, std::string_view detail,
           const std::string& reader) const {
    if (action == SQLITE_READ) return detail.empty() ? may_count(what) : may_read(what, reader);
    if (action == SQLITE_FUNCTION) return detail != "load_extension";
    return action == SQLITE_SELECT || action == SQLITE_RECURSIVE;
  }

  bool may_read(const std::string& table, const std::string& reader) const {
    if (outer_.count(table) > 0 || inner_.count(reader) > 0) return true;
    return inner_.count(table) > 0 && outer_.count(reader) > 0;
  }

  // Rows are counted in nobody's name and without a column, on the table of a flattened view, on a
  // subquery or function of any name, or on a table that no view is made of: only that is refused.
  bool may_count(const std::string& table) const {
    return hidden_.count(table) == 0 && table.rfind("sqlite_", 0) != 0;
  }

  static int look_at_limits(void* self) {
    Door& door = *static_cast<Door*>(self);
    if (door.cancelled_)
      door.stopped_ = Error{ErrorCode::cancelled, "the caller has left", ""};
    else if (Clock::now() > door.deadline_)
      door.stopped_ =
          Error{ErrorCode::deadline_exceeded, "the query ran into its time limit", "sql"};
    else if (sqlite3_memory_used() > door.memory_limit_)
      door.stopped_ =
          Error{ErrorCode::resource_exhausted, "the query needs too much memory", "sql"};
    return door.stopped_.message.empty() ? 0 : 1;
  }

  // What SQLite held when the first query came: the server's own cache.
  static std::int64_t base_memory() {
    static const std::int64_t bytes = std::max<std::int64_t>(sqlite3_memory_used(), 64ll << 20);
    return bytes;
  }

  Error error_of(int status) {
    if (!stopped_.message.empty()) return stopped_;
    const std::string message =
        one_line(sqlite3_errmsg(connection_.get()));  // it quotes the statement
    const bool a_view_is_written = message.rfind("cannot modify", 0) == 0;
    if (status == SQLITE_AUTH || denied_ || a_view_is_written) return refused(message);
    if (status == SQLITE_NOMEM || status == SQLITE_TOOBIG)
      return {ErrorCode::resource_exhausted, message, "sql"};
    if (status == SQLITE_BUSY) return {ErrorCode::unavailable, message, "sql"};
    return {ErrorCode::invalid_argument, message, "sql"};
  }

  Result<Statement> compile(const std::string& sql) {
    if (sql.size() > kMaxSqlBytes)
      return Error{ErrorCode::invalid_argument, "the statement is too long", "sql"};
    if (sql.find('\0') != std::string::npos)
      return Error{ErrorCode::invalid_argument, "the statement contains a NUL character", "sql"};
    sqlite3_stmt* made = nullptr;
    const char* rest = nullptr;
    const int status = sqlite3_prepare_v2(connection_.get(), sql.c_str(), -1, &made, &rest);
    Statement statement(made);
    if (status != SQLITE_OK) return error_of(status);
    if (made == nullptr) return Error{ErrorCode::invalid_argument, "there is no statement", "sql"};
    if (sqlite3_stmt_isexplain(made) != 0) return refused("EXPLAIN is not authorized");
    if (sqlite3_stmt_readonly(made) == 0 || sqlite3_column_count(made) == 0)
      return refused("not a SELECT");
    sqlite3_stmt* second = nullptr;
    const int behind = sqlite3_prepare_v2(connection_.get(), rest, -1, &second, nullptr);
    const Statement also(second);
    if (behind != SQLITE_OK || second != nullptr)
      return Error{ErrorCode::invalid_argument, "one statement at a time", "sql"};
    return statement;
  }

  Status stream(sqlite3_stmt* statement, const QueryLimits& limits, RowSink& sink) {
    const int count = sqlite3_column_count(statement);
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.emplace_back(sqlite3_column_name(statement, i));
    sink.columns(names);
    for (std::uint64_t rows = 0;; ++rows) {
      const int status = sqlite3_step(statement);
      if (status == SQLITE_DONE) return Done{};
      if (status != SQLITE_ROW) return error_of(status);
      if (rows == limits.rows)
        return Error{ErrorCode::resource_exhausted,
                     "more than " + std::to_string(limits.rows) +
                         " rows: aggregate, or add LIMIT, or ask for more (row_limit)",
                     "sql"};
      std::vector<Cell> cells;
      cells.reserve(static_cast<std::size_t>(count));
      for (int i = 0; i < count; ++i) cells.push_back(cell(statement, i));
      if (!sink.row(std::move(cells)))
        return Error{ErrorCode::cancelled, "the caller has left", ""};
    }
  }

  static Cell cell(sqlite3_stmt* statement, int i) {
    const auto size = [&] { return static_cast<std::size_t>(sqlite3_column_bytes(statement, i)); };
    switch (sqlite3_column_type(statement, i)) {
      case SQLITE_INTEGER:
        return static_cast<std::int64_t>(sqlite3_column_int64(statement, i));
      case SQLITE_FLOAT:
        return sqlite3_column_double(statement, i);
      case SQLITE_TEXT: {
        const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, i));
        return std::string(text, size());
      }
      case SQLITE_BLOB: {
        const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement, i));
        return bytes ? Blob(bytes, bytes + size()) : Blob();
      }
      default:
        return std::monostate{};
    }
  }

  std::unique_ptr<sqlite3, CloseConnection> connection_;
  std::optional<JobFunctions> job_functions_;
  const std::atomic<bool>& cancelled_;
  std::unordered_set<std::string> inner_, outer_;
  std::unordered_set<std::string> hidden_;  // tables that no view is made of
  Clock::time_point deadline_ = Clock::time_point::max();
  std::int64_t memory_limit_ = std::numeric_limits<std::int64_t>::max();
  bool denied_ = false;
  Error stopped_{ErrorCode::unknown, "", ""};
};

const std::atomic<bool> kNever = false;

}  // namespace

Status run_query(const std::filesystem::path& database, const std::string& sql,
                 const QueryLimits& limits, RowSink& sink, const std::atomic<bool>& cancelled) {
  try {
    Door door(database, cancelled);
    door.close_behind_views();
    return door.run(sql, limits, sink);
  } catch (const std::exception& error) {
    return Error{ErrorCode::internal, error.what(), ""};
  }
}

std::vector<ViewText> list_views(const std::filesystem::path& database) {
  return Door(database, kNever).views();
}

}  // namespace granary::server
