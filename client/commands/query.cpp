// granary query: read-only SQL over the server's documented views.
#include <iostream>
#include <iterator>

#include "client/commands/catalogue.h"
#include "client/commands/duration.h"

namespace granary::commands {
namespace {

using render::Json;

struct QueryOptions {
  std::string sql;
  bool schema = false;
  std::uint32_t limit = 0;
  std::string time_limit;
};

std::string hex(const std::string& bytes) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

Json cell_json(const v1::QueryCell& cell) {
  switch (cell.kind_case()) {
    case v1::QueryCell::kInteger:
      return cell.integer();
    case v1::QueryCell::kReal:
      return render::number_or_null(cell.real());
    case v1::QueryCell::kText:
      return cell.text();
    case v1::QueryCell::kBlob:
      return hex(cell.blob());
    case v1::QueryCell::KIND_NOT_SET:
      break;
  }
  return nullptr;
}

// JSON objects need distinct keys: "n", "n_2", ...
std::vector<std::string> distinct(std::vector<std::string> names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string base = names[i];
    for (int count = 2; std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i),
                                  names[i]) != names.begin() + static_cast<std::ptrdiff_t>(i);
         ++count)
      names[i] = base + "_" + std::to_string(count);
  }
  return names;
}

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
  auto session = context.session();
  if (!session) return session.error();
  // All rows first: a query that fails half-way prints no half of an answer.
  render::Table table;
  const Status answered = (*session)->query(*request, [&](const v1::QueryRows& rows) -> Status {
    if (rows.columns_size() > 0)
      table.columns = distinct({rows.columns().begin(), rows.columns().end()});
    for (const v1::QueryRow& row : rows.rows()) {
      auto& cells = table.rows.emplace_back();
      for (const v1::QueryCell& cell : row.cells()) cells.push_back(cell_json(cell));
    }
    return Done{};
  });
  if (!answered) return answered.error();
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
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
