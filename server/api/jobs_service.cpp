#include "server/api/jobs_service.h"

#include <charconv>

#include "proto/contract/version.h"
#include "server/api/download_stream.h"
#include "server/api/job_messages.h"
#include "server/api/watch_stream.h"

namespace granary::server {
namespace {

constexpr int kMaxBatch = 10'000;
constexpr std::uint32_t kMaxPage = 1000;

Error bad_name(const std::string& name) {
  return {ErrorCode::not_found, "no job '" + name + "', names look like jobs/17", "name"};
}

grpc::ServerUnaryReactor* refuse(grpc::CallbackServerContext* context, const Error& error) {
  auto* reactor = context->DefaultReactor();
  reactor->Finish(to_grpc(error, context));
  return reactor;
}

// A call about one job: finds the id, runs `work(id)` by answer_on_owner or look_on_owner.
template <typename Request>
grpc::ServerUnaryReactor* about_job(Backend& backend, grpc::CallbackServerContext* context,
                                    const Request* request, std::function<Status(JobId)> work,
                                    decltype(answer_on_owner)& way = answer_on_owner) {
  const auto id = job_id_from(request->name());
  if (!id) return refuse(context, bad_name(request->name()));
  return way(backend, context, [id = *id, work = std::move(work)] { return work(id); });
}

Status fill(const Result<JobRecord>& job, v1::Job* response) {
  if (!job.ok()) return job.error();
  *response = to_message(*job);
  return Done{};
}

Result<Submission> read_submission(const v1::SubmitJobsRequest& request, const std::string& owner) {
  if (request.items_size() == 0)
    return Error{ErrorCode::invalid_argument, "items is empty: nothing to submit", "items"};
  if (request.items_size() > kMaxBatch)
    return Error{ErrorCode::invalid_argument,
                 "items has more than " + std::to_string(kMaxBatch) + " entries", "items"};
  Submission submission;
  submission.request_id = request.request_id();
  for (int i = 0; i < request.items_size(); ++i) {
    auto job = to_new_job(request.items(i), owner);
    if (!job) {
      const std::string prefix =
          request.items_size() > 1 ? "items[" + std::to_string(i) + "]: " : "";
      return Error{job.error().code, prefix + job.error().message, job.error().field_path};
    }
    submission.jobs.push_back(std::move(*job));
  }
  return submission;
}

}  // namespace

grpc::ServerUnaryReactor* JobsService::Submit(grpc::CallbackServerContext* context,
                                              const v1::SubmitJobsRequest* request,
                                              v1::SubmitJobsResponse* response) {
  const std::string owner = owner_of(*context);
  if (const int wait_ms = backend_.submissions.take(owner, request->items_size(), system_now().steady_ms); wait_ms > 0)
    return refuse(context, {ErrorCode::resource_exhausted, owner + " submits faster than this server takes: nothing was queued, try again later",
                            "", wait_ms});
  auto submission = read_submission(*request, owner);  // parsing and resolving stay off the owner thread
  if (!submission) return refuse(context, submission.error());
  return answer_on_owner(backend_, context,
                         [this, response, submission = std::move(*submission)]() -> Status {
                           auto ids = backend_.dispatcher.submit(submission, system_now());
                           if (!ids) return ids.error();
                           for (const JobId id : *ids) response->add_names(job_name(id));
                           return Done{};
                         });
}

grpc::ServerUnaryReactor* JobsService::Get(grpc::CallbackServerContext* context,
                                           const v1::GetJobRequest* request, v1::Job* response) {
  return about_job(
      backend_, context, request,
      [this, response](JobId id) {
        Status status = fill(backend_.dispatcher.find(id), response);
        if (const v1::JobEvent* event = backend_.dispatcher.progress(id))
          *response->mutable_progress() = event->progress();
        return status;
      },
      look_on_owner);
}

grpc::ServerUnaryReactor* JobsService::List(grpc::CallbackServerContext* context,
                                            const v1::ListJobsRequest* request,
                                            v1::ListJobsResponse* response) {
  ListFilter filter;
  filter.kind = request->kind();
  if (request->state() != v1::JOB_STATE_UNSPECIFIED) filter.state = request->state();
  filter.tags = {request->tags().begin(), request->tags().end()};
  filter.limit = request->page_size() == 0 ? 100 : std::min(request->page_size(), kMaxPage);
  const std::string& token = request->page_token();
  if (!token.empty() &&
      std::from_chars(token.data(), token.data() + token.size(), filter.before).ec != std::errc())
    return refuse(context,
                  {ErrorCode::invalid_argument, "page_token is not one of ours", "page_token"});
  return look_on_owner(backend_, context, [this, response, filter]() -> Status {
    const auto jobs = backend_.store.list_jobs(filter);
    for (const JobRecord& job : jobs) {
      v1::Job* message = response->add_jobs();
      *message = to_message(job);
      if (const v1::JobEvent* event = backend_.dispatcher.progress(job.id))
        *message->mutable_progress() = event->progress();
    }
    if (jobs.size() == filter.limit) response->set_next_page_token(std::to_string(jobs.back().id));
    return Done{};
  });
}

grpc::ServerWriteReactor<v1::JobEvent>* JobsService::Watch(grpc::CallbackServerContext*,
                                                           const v1::WatchJobRequest* request) {
  return watch_job(backend_, *request);
}

grpc::ServerUnaryReactor* JobsService::Cancel(grpc::CallbackServerContext* context,
                                              const v1::CancelJobRequest* request,
                                              v1::Job* response) {
  return about_job(backend_, context, request, [this, response](JobId id) {
    return fill(backend_.dispatcher.cancel(id, system_now()), response);
  });
}

grpc::ServerUnaryReactor* JobsService::Retry(grpc::CallbackServerContext* context,
                                             const v1::RetryJobRequest* request,
                                             v1::Job* response) {
  return about_job(backend_, context, request, [this, response](JobId id) {
    return fill(backend_.dispatcher.retry(id, system_now()), response);
  });
}

grpc::ServerUnaryReactor* JobsService::Delete(grpc::CallbackServerContext* context,
                                              const v1::DeleteJobRequest* request,
                                              v1::DeleteJobResponse*) {
  return about_job(backend_, context, request,
                   [this](JobId id) { return backend_.dispatcher.remove(id); });
}

grpc::ServerUnaryReactor* JobsService::GetValues(grpc::CallbackServerContext* context,
                                                 const v1::GetValuesRequest* request,
                                                 v1::GetValuesResponse* response) {
  return about_job(
      backend_, context, request,
      [this, response](JobId id) -> Status {
        auto job = backend_.dispatcher.find(id);
        if (!job) return job.error();
        response->set_name(job_name(id));
        response->set_kind(job->kind);
        response->set_state(job->state);
        response->set_error(job->error);
        response->set_timed_out(job->timed_out);
        if (auto result = backend_.store.find_result(id))
          *response->mutable_result() = std::move(*result);
        return Done{};
      },
      look_on_owner);
}

grpc::ServerUnaryReactor* JobsService::GetLogs(grpc::CallbackServerContext* context,
                                               const v1::GetLogsRequest* request,
                                               v1::GetLogsResponse* response) {
  return about_job(
      backend_, context, request,
      [this, response](JobId id) -> Status {
        if (auto job = backend_.dispatcher.find(id); !job) return job.error();
        for (std::string& line : backend_.store.logs(id)) response->add_lines(std::move(line));
        return Done{};
      },
      look_on_owner);
}

grpc::ServerWriteReactor<v1::DownloadChunk>* JobsService::Download(
    grpc::CallbackServerContext*, const v1::DownloadRequest* request) {
  backend_.touch();
  return send_artifact(backend_, [this, request]() -> Result<DownloadRange> {
    const auto id = job_id_from(request->name());
    if (!id) return bad_name(request->name());
    auto job = backend_.dispatcher.find(*id);
    if (!job) return job.error();
    if (job->result_sha256.empty())
      return Error{ErrorCode::failed_precondition, request->name() + " has no result file yet",
                   "name"};
    return DownloadRange{
        {job->result_sha256, job->result_bytes}, request->offset_bytes(), request->limit_bytes()};
  });
}

grpc::ServerUnaryReactor* JobsService::GetServerInfo(grpc::CallbackServerContext* context,
                                                     const v1::GetServerInfoRequest*,
                                                     v1::GetServerInfoResponse* response) {
  return look_on_owner(backend_, context, [this, response]() -> Status {
    response->set_version(kProductVersion);
    response->set_engine_version(kEngineVersion);
    const QueueTally& tally = backend_.dispatcher.tally();
    response->set_waiting(tally.waiting());
    response->set_running(tally.running());
    for (const v1::WorkerInfo& worker : backend_.dispatcher.list_workers(system_now())) {
      if (worker.state() != "connected") continue;
      response->set_workers(response->workers() + 1);
      response->set_slots(response->slots() + worker.slots());
    }
    return Done{};
  });
}

}  // namespace granary::server
