#include "client/commands/query_rows.h"

#include <algorithm>

namespace granary::commands {
namespace {

using render::Json;

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

}  // namespace

Result<render::Table> query_rows(Context& context, const v1::QueryRequest& request) {
  auto session = context.session();
  if (!session) return session.error();
  render::Table table;
  const Status answered = (*session)->query(request, [&](const v1::QueryRows& rows) -> Status {
    if (rows.columns_size() > 0)
      table.columns = distinct({rows.columns().begin(), rows.columns().end()});
    for (const v1::QueryRow& row : rows.rows()) {
      auto& cells = table.rows.emplace_back();
      for (const v1::QueryCell& cell : row.cells()) cells.push_back(cell_json(cell));
    }
    return Done{};
  });
  if (!answered) return answered.error();
  return table;
}

Result<render::Table> query_rows(Context& context, const std::string& sql) {
  v1::QueryRequest request;
  request.set_sql(sql);
  return query_rows(context, request);
}

}  // namespace granary::commands
