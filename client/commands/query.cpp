// granary query: read-only SQL over the server's documented views.
#include <iostream>
#include <iterator>

#include "client/commands/catalogue.h"
#include "client/commands/duration.h"
#include "client/commands/query_rows.h"

namespace granary::commands {
namespace {

struct QueryOptions {
  std::string sql;
  bool schema = false;
  std::uint32_t limit = 0;
  std::string time_limit;
};

Outcome schema(Context& context) {
  auto session = context.session();
  if (!session) return session.error();
  auto schema = (*session)->query_schema();
  if (!schema) return schema.error();
  render::Table table{{"view", "column", "meaning"}, {}};
  for (const v1::View& view : schema->views())
    for (const v1::ViewColumn& column : view.columns())
      table.rows.push_back({view.name(), column.name(), column.meaning()});
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

Result<v1::QueryRequest> request_of(const QueryOptions& options) {
  v1::QueryRequest request;
  request.set_sql(options.sql);
  if (options.sql == "-")
    request.set_sql(std::string(std::istreambuf_iterator<char>(std::cin), {}));
  request.set_row_limit(options.limit);
  if (options.time_limit.empty()) return request;
  auto seconds = parse_duration_s(options.time_limit);
  if (!seconds)
    return Error{ErrorCode::invalid_argument, "--time-limit " + seconds.error().message, ""};
  request.set_time_limit_s(*seconds);
  return request;
}

Outcome query(Context& context, const QueryOptions& options) {
  if (options.schema) return schema(context);
  if (options.sql.empty())
    return Error{ErrorCode::invalid_argument,
                 "say what to ask: granary query \"SELECT ...\" or --schema", ""};
  auto request = request_of(options);
  if (!request) return request.error();
  auto table = query_rows(context, *request);
  if (!table) return table.error();
  if (auto written = context.write_rows(*table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_query(CommandLine& line) {
  auto options = std::make_shared<QueryOptions>();
  CLI::App& verb = line.verb("query", "Ask about what is stored, in SQL (read-only)",
                             "granary query \"SELECT job, f1_m, f1_error_m FROM discharge_values "
                             "ORDER BY f1_m DESC LIMIT 5\"");
  verb.add_option("SQL", options->sql, "one SELECT over the views of --schema; - reads stdin")
      ->type_name("");
  verb.add_flag("--schema", options->schema, "the views and their columns");
  verb.add_option("--limit", options->limit, "allow this many rows (default 100,000)");
  verb.add_option("--time-limit", options->time_limit, "default 10s, at most 60s")
      ->type_name("DURATION");
  line.on(verb, [options](Context& context) { return query(context, *options); });
}

}  // namespace granary::commands
