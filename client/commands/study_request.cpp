#include "client/commands/study_request.h"

#include <cstdlib>

#include "client/commands/studies.h"

namespace granary::commands {
namespace {

using render::Json;

Json cell_json(const v1::QueryCell& cell) {
  switch (cell.kind_case()) {
    case v1::QueryCell::kInteger:
      return cell.integer();
    case v1::QueryCell::kReal:
      return render::number_or_null(cell.real());
    case v1::QueryCell::kText:
      return cell.text();
    default:
      return nullptr;
  }
}

}  // namespace

Result<v1::SubmitStudyRequest> study_request(Context& context, const SubmissionOptions& options) {
  auto settings = context.settings();
  if (!settings) return settings.error();
  const int threads = std::atoi((*settings)[session::SettingKey::threads].value.c_str());
  auto jobs = make_request(options, static_cast<std::uint32_t>(threads));
  if (!jobs) return jobs.error();
  const auto& item = jobs->items(0);
  v1::SubmitStudyRequest request;
  request.set_request_id(options.request_id);
  v1::StudySpec& spec = *request.mutable_spec();
  *spec.mutable_scene() = item.scene();
  *spec.mutable_tags() = item.tags();
  spec.set_priority(item.priority());
  spec.set_time_limit_s(item.time_limit_s());
  spec.set_fresh(item.fresh());
  return request;
}

Result<render::Table> query_rows(Context& context, const std::string& sql) {
  auto session = context.session();
  if (!session) return session.error();
  v1::QueryRequest request;
  request.set_sql(sql);
  render::Table table;
  const Status answered = (*session)->query(request, [&](const v1::QueryRows& rows) -> Status {
    if (rows.columns_size() > 0) table.columns = {rows.columns().begin(), rows.columns().end()};
    for (const v1::QueryRow& row : rows.rows()) {
      auto& cells = table.rows.emplace_back();
      for (const v1::QueryCell& cell : row.cells()) cells.push_back(cell_json(cell));
    }
    return Done{};
  });
  if (!answered) return answered.error();
  return table;
}

Result<std::optional<v1::Study>> run_study(Context& context, v1::SubmitStudyRequest request) {
  auto session = context.session();
  if (!session) return session.error();
  auto study = (*session)->submit_study(std::move(request));
  if (!study) return study.error();
  const Outcome outcome = follow_study(context, study->name(), false);
  if (!outcome) return outcome.error();
  if (*outcome == ExitCode::interrupted) return std::optional<v1::Study>();
  auto ended = (*session)->get_study(study->name());
  if (!ended) return ended.error();
  return std::optional<v1::Study>(std::move(*ended));
}

}  // namespace granary::commands
