#include "server/api/studies_service.h"

#include <charconv>

#include "server/api/study_messages.h"
#include "server/api/study_watch_stream.h"

namespace granary::server {
namespace {

constexpr std::uint32_t kMaxPage = 1000;

grpc::ServerUnaryReactor* refuse(grpc::CallbackServerContext* context, const Error& error) {
  auto* reactor = context->DefaultReactor();
  reactor->Finish(to_grpc(error));
  return reactor;
}

// A call about one study that answers with the study as it is afterwards.
template <typename Request>
grpc::ServerUnaryReactor* about_study(Backend& backend, grpc::CallbackServerContext* context,
                                      const Request* request, v1::Study* response,
                                      std::function<Result<StudyRecord>(StudyId)> work) {
  const auto id = study_id_from(request->name());
  if (!id)
    return refuse(context,
                  {ErrorCode::not_found,
                   "no study '" + request->name() + "', names look like studies/3", "name"});
  return answer_on_owner(backend, context,
                         [id = *id, response, work = std::move(work)]() -> Status {
                           auto study = work(id);
                           if (!study) return study.error();
                           *response = to_message(*study);
                           return Done{};
                         });
}

// "" = from the start; nothing for a token that is not ours.
std::optional<std::int64_t> number_of(const std::string& token) {
  std::int64_t number = 0;
  if (token.empty()) return number;
  const char* end = token.data() + token.size();
  const auto [rest, error] = std::from_chars(token.data(), end, number);
  if (error != std::errc() || rest != end || number < 0) return {};
  return number;
}

Error bad_token() {
  return {ErrorCode::invalid_argument, "page_token is not one of ours", "page_token"};
}

std::uint32_t page_limit(std::uint32_t asked) {
  return asked == 0 ? 100 : std::min(asked, kMaxPage);
}

}  // namespace

grpc::ServerUnaryReactor* StudiesService::Submit(grpc::CallbackServerContext* context,
                                                 const v1::SubmitStudyRequest* request,
                                                 v1::Study* response) {
  // A bad spec is found here, off the owner thread; the director makes its own generator.
  if (auto generator = make_generator(request->spec()); !generator)
    return refuse(context, generator.error());
  NewStudy study{request->spec(), owner_of(*context), request->request_id()};
  return answer_on_owner(backend_, context, [this, response, study = std::move(study)]() -> Status {
    auto record = backend_.studies.submit(study, system_now());
    if (!record) return record.error();
    *response = to_message(*record);
    return Done{};
  });
}

grpc::ServerUnaryReactor* StudiesService::Get(grpc::CallbackServerContext* context,
                                              const v1::GetStudyRequest* request,
                                              v1::Study* response) {
  return about_study(backend_, context, request, response,
                     [this](StudyId id) { return backend_.studies.find(id); });
}

grpc::ServerUnaryReactor* StudiesService::List(grpc::CallbackServerContext* context,
                                               const v1::ListStudiesRequest* request,
                                               v1::ListStudiesResponse* response) {
  const auto before = number_of(request->page_token());
  if (!before) return refuse(context, bad_token());
  return look_on_owner(backend_, context,
                       [this, response, before = *before, kind = request->kind(),
                        limit = page_limit(request->page_size())]() -> Status {
                         const auto studies =
                             backend_.study_store.list_studies(kind, before, limit);
                         for (const StudyRecord& study : studies)
                           *response->add_studies() = to_message(study);
                         if (studies.size() == limit)
                           response->set_next_page_token(std::to_string(studies.back().id));
                         return Done{};
                       });
}

grpc::ServerWriteReactor<v1::Study>* StudiesService::Watch(grpc::CallbackServerContext*,
                                                           const v1::WatchStudyRequest* request) {
  return watch_study(backend_, *request);
}

grpc::ServerUnaryReactor* StudiesService::Pause(grpc::CallbackServerContext* context,
                                                const v1::PauseStudyRequest* request,
                                                v1::Study* response) {
  return about_study(backend_, context, request, response,
                     [this](StudyId id) { return backend_.studies.pause(id, system_now()); });
}

grpc::ServerUnaryReactor* StudiesService::Resume(grpc::CallbackServerContext* context,
                                                 const v1::ResumeStudyRequest* request,
                                                 v1::Study* response) {
  return about_study(backend_, context, request, response,
                     [this](StudyId id) { return backend_.studies.resume(id, system_now()); });
}

grpc::ServerUnaryReactor* StudiesService::Extend(grpc::CallbackServerContext* context,
                                                 const v1::ExtendStudyRequest* request,
                                                 v1::Study* response) {
  return about_study(backend_, context, request, response,
                     [this, budget = request->budget()](StudyId id) {
                       return backend_.studies.extend(id, budget, system_now());
                     });
}

grpc::ServerUnaryReactor* StudiesService::Cancel(grpc::CallbackServerContext* context,
                                                 const v1::CancelStudyRequest* request,
                                                 v1::Study* response) {
  return about_study(backend_, context, request, response,
                     [this, keep = request->keep_jobs()](StudyId id) {
                       return backend_.studies.cancel(id, keep, system_now());
                     });
}

grpc::ServerUnaryReactor* StudiesService::ListTrials(grpc::CallbackServerContext* context,
                                                     const v1::ListTrialsRequest* request,
                                                     v1::ListTrialsResponse* response) {
  const auto id = study_id_from(request->name());
  const auto after = number_of(request->page_token());
  if (!after) return refuse(context, bad_token());
  return look_on_owner(
      backend_, context,
      [this, response, id = id.value_or(0), after = static_cast<std::uint32_t>(*after),
       limit = page_limit(request->page_size())]() -> Status {
        if (auto study = backend_.studies.find(id); !study) return study.error();
        const auto trials = backend_.study_store.trials_after(id, after, limit);
        for (const TrialRecord& trial : trials)
          *response->add_trials() = to_message(trial, backend_.store);
        if (trials.size() == limit)
          response->set_next_page_token(std::to_string(trials.back().number));
        return Done{};
      });
}

}  // namespace granary::server
