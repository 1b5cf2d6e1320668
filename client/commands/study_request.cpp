#include "client/commands/study_request.h"

#include <cstdlib>

#include "client/commands/studies.h"

namespace granary::commands {

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
