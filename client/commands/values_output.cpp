#include "client/commands/values_output.h"

#include <map>

#include "proto/contract/job_state.h"
#include "proto/contract/values_json.h"

namespace granary::commands {
namespace {

using render::Json;

Json optional_number(bool known, double value) {
  return known ? render::number_or_null(value) : Json(nullptr);
}

void add_rows(const v1::GetValuesResponse& response, render::Table& table) {
  const std::map<std::string, v1::Quantity> sorted(response.result().values().begin(),
                                                   response.result().values().end());
  for (const auto& [name, quantity] : sorted)
    table.rows.push_back(
        {response.name(), name, optional_number(quantity.has_value(), quantity.value()),
         optional_number(quantity.has_error(), quantity.error()),
         quantity.unit().empty() ? Json(nullptr) : Json(quantity.unit()),
         quantity.error_basis().empty() ? Json(nullptr) : Json(quantity.error_basis())});
}

}  // namespace

Status write_values(Context& context, const std::vector<v1::GetValuesResponse>& responses) {
  if (context.format() == render::Format::json) {
    std::string lines;
    for (const auto& response : responses) lines += values_json(response) + "\n";
    return context.write(lines);
  }
  for (const auto& response : responses)  // json has them in its line
    for (const std::string& warning : response.result().warnings())
      context.say("warning: " + response.name() + ": " + warning);
  render::Table table{{"job", "observable", "value", "error", "unit", "error_basis"}, {}};
  for (const auto& response : responses) add_rows(response, table);
  if (table.rows.empty() && context.format() == render::Format::table) return Done{};
  return context.write_rows(table, render::JsonShape::lines);
}

Status write_values_of(Context& context, const std::vector<std::string>& names) {
  auto session = context.session();
  if (!session) return session.error();
  std::vector<v1::GetValuesResponse> responses;
  for (const std::string& name : names) {
    auto values = (*session)->values(name);
    if (!values) return values.error();
    responses.push_back(*values);
  }
  return write_values(context, responses);
}

}  // namespace granary::commands
