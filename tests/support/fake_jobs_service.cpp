#include "tests/support/fake_jobs_service.h"

#include <grpc/grpc.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "granary/v1/job.grpc.pb.h"
#include "granary/v1/worker.grpc.pb.h"
#include "proto/contract/job_state.h"

namespace granary::test {
namespace {

constexpr std::size_t kChunk_bytes = 1000;

const grpc::Status kLost(grpc::StatusCode::UNAVAILABLE, "connection reset");

}  // namespace

v1::JobEvent state_event(std::uint64_t sequence, v1::JobState state) {
  v1::JobEvent event;
  event.set_sequence(sequence);
  event.set_state(state);
  return event;
}

v1::JobEvent progress_event(std::uint64_t sequence, double fraction) {
  v1::JobEvent event;
  event.set_sequence(sequence);
  event.mutable_progress()->set_fraction(fraction);
  event.mutable_progress()->set_phase("rotation");
  return event;
}

FakeJob& FakeJobs::add(const std::string& name, v1::JobState state) {
  const std::lock_guard lock(mutex_);
  FakeJob& fake = jobs_[name];
  fake.job.set_name(name);
  fake.job.set_kind("discharge");
  fake.job.set_state(state);
  fake.values.set_name(name);
  fake.values.set_kind("discharge");
  fake.values.set_state(state);
  fake.events = {state_event(1, v1::WAITING), state_event(2, v1::RUNNING), progress_event(3, 0.25),
                 progress_event(4, 0.5)};
  if (is_final(state)) fake.events.push_back(state_event(5, state));
  return fake;
}

void FakeJobs::lose_replies(const std::string& method, int count) {
  const std::lock_guard lock(mutex_);
  lost_replies_[method] = count;
}

void FakeJobs::fail(const std::string& method, ErrorCode code, const std::string& message) {
  const std::lock_guard lock(mutex_);
  failures_[method] = {code, message};
}

std::vector<v1::SubmitJobsRequest> FakeJobs::submissions() {
  const std::lock_guard lock(mutex_);
  return submissions_;
}

std::vector<v1::WatchJobRequest> FakeJobs::watches() {
  const std::lock_guard lock(mutex_);
  return watches_;
}

std::vector<v1::DownloadRequest> FakeJobs::downloads() {
  const std::lock_guard lock(mutex_);
  return downloads_;
}

int FakeJobs::calls(const std::string& method) {
  const std::lock_guard lock(mutex_);
  return calls_[method];
}

class FakeJobsService final : public v1::Jobs::Service {
 public:
  explicit FakeJobsService(FakeJobs& fake) : fake_(fake) {}

  using Context = grpc::ServerContext;
  grpc::Status Submit(Context*, const v1::SubmitJobsRequest*, v1::SubmitJobsResponse*) override;
  grpc::Status Get(Context*, const v1::GetJobRequest*, v1::Job*) override;
  grpc::Status List(Context*, const v1::ListJobsRequest*, v1::ListJobsResponse*) override;
  grpc::Status Watch(Context*, const v1::WatchJobRequest*,
                     grpc::ServerWriter<v1::JobEvent>*) override;
  grpc::Status Cancel(Context*, const v1::CancelJobRequest*, v1::Job*) override;
  grpc::Status Retry(Context*, const v1::RetryJobRequest*, v1::Job*) override;
  grpc::Status Delete(Context*, const v1::DeleteJobRequest*, v1::DeleteJobResponse*) override;
  grpc::Status GetValues(Context*, const v1::GetValuesRequest*, v1::GetValuesResponse*) override;
  grpc::Status GetLogs(Context*, const v1::GetLogsRequest*, v1::GetLogsResponse*) override;
  grpc::Status Download(Context*, const v1::DownloadRequest*,
                        grpc::ServerWriter<v1::DownloadChunk>*) override;
  grpc::Status GetServerInfo(Context*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override;

 private:
  // Counts the call and judges the token; OK to go on.
  grpc::Status enter(Context* context, const std::string& method);
  // UNAVAILABLE when this reply is to be lost.
  grpc::Status leave(const std::string& method);
  template <typename Change>
  grpc::Status on_job(Context* context, const std::string& method, const std::string& name,
                      const Change& change);

  FakeJobs& fake_;
};

class FakeWorkersService final : public v1::Workers::Service {
 public:
  grpc::Status List(grpc::ServerContext*, const v1::ListWorkersRequest*,
                    v1::ListWorkersResponse* response) override;
};

grpc::Status FakeJobsService::enter(Context* context, const std::string& method) {
  ++fake_.calls_[method];
  const auto& metadata = context->client_metadata();
  const auto found = metadata.find("authorization");
  const std::string given =
      found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
  if (!fake_.token_.empty() && given != "Bearer " + fake_.token_)
    return {grpc::StatusCode::UNAUTHENTICATED, "a valid token is needed"};
  const auto failure = fake_.failures_.find(method);
  if (failure == fake_.failures_.end()) return grpc::Status::OK;
  const auto& [code, message] = failure->second;
  return {static_cast<grpc::StatusCode>(code), message};
}

grpc::Status FakeJobsService::leave(const std::string& method) {
  return fake_.lost_replies_[method]-- > 0 ? kLost : grpc::Status::OK;
}

grpc::Status FakeJobsService::Submit(Context* context, const v1::SubmitJobsRequest* request,
                                     v1::SubmitJobsResponse* response) {
  std::unique_lock lock(fake_.mutex_);
  if (auto status = enter(context, "Submit"); !status.ok()) return status;
  fake_.submissions_.push_back(*request);
  std::vector<std::string>& names = fake_.by_request_id_[request->request_id()];
  if (names.empty())
    for (int i = 0; i < request->items_size(); ++i) {
      names.push_back("jobs/new" + std::to_string(fake_.jobs_.size() + 1));
      lock.unlock();
      fake_.add(names.back());
      lock.lock();
    }
  *response->mutable_names() = {names.begin(), names.end()};
  return leave("Submit");
}

template <typename Change>
grpc::Status FakeJobsService::on_job(Context* context, const std::string& method,
                                     const std::string& name, const Change& change) {
  const std::lock_guard lock(fake_.mutex_);
  if (auto status = enter(context, method); !status.ok()) return status;
  const auto found = fake_.jobs_.find(name);
  if (found == fake_.jobs_.end()) return {grpc::StatusCode::NOT_FOUND, name + " does not exist"};
  change(found);
  return leave(method);
}

grpc::Status FakeJobsService::Get(Context* context, const v1::GetJobRequest* request,
                                  v1::Job* job) {
  return on_job(context, "Get", request->name(), [&](auto found) { *job = found->second.job; });
}

grpc::Status FakeJobsService::Cancel(Context* context, const v1::CancelJobRequest* request,
                                     v1::Job* job) {
  return on_job(context, "Cancel", request->name(), [&](auto found) {
    found->second.job.set_state(v1::CANCELLED);
    *job = found->second.job;
  });
}

grpc::Status FakeJobsService::Retry(Context* context, const v1::RetryJobRequest* request,
                                    v1::Job* job) {
  bool has_ended = false;
  const auto status = on_job(context, "Retry", request->name(), [&](auto found) {
    has_ended = is_final(found->second.job.state());
    found->second.job.set_state(v1::WAITING);
    *job = found->second.job;
  });
  if (!status.ok() || has_ended) return status;
  return {grpc::StatusCode::FAILED_PRECONDITION, request->name() + " is queued already"};
}

grpc::Status FakeJobsService::Delete(Context* context, const v1::DeleteJobRequest* request,
                                     v1::DeleteJobResponse*) {
  return on_job(context, "Delete", request->name(), [&](auto found) { fake_.jobs_.erase(found); });
}

grpc::Status FakeJobsService::GetValues(Context* context, const v1::GetValuesRequest* request,
                                        v1::GetValuesResponse* response) {
  return on_job(context, "GetValues", request->name(),
                [&](auto found) { *response = found->second.values; });
}

grpc::Status FakeJobsService::GetLogs(Context* context, const v1::GetLogsRequest* request,
                                      v1::GetLogsResponse* response) {
  return on_job(context, "GetLogs", request->name(), [&](auto found) {
    for (const std::string& line : found->second.logs) response->add_lines(line);
  });
}

grpc::Status FakeJobsService::List(Context* context, const v1::ListJobsRequest* request,
                                   v1::ListJobsResponse* response) {
  const std::lock_guard lock(fake_.mutex_);
  if (auto status = enter(context, "List"); !status.ok()) return status;
  for (const auto& [name, fake] : fake_.jobs_) {
    if (name <= request->page_token()) continue;
    if (request->state() != v1::JOB_STATE_UNSPECIFIED && request->state() != fake.job.state())
      continue;
    if (response->jobs_size() == static_cast<int>(request->page_size())) {
      response->set_next_page_token(response->jobs(response->jobs_size() - 1).name());
      break;
    }
    *response->add_jobs() = fake.job;
  }
  return leave("List");
}

grpc::Status FakeJobsService::Watch(Context* context, const v1::WatchJobRequest* request,
                                    grpc::ServerWriter<v1::JobEvent>* writer) {
  FakeJob fake;
  std::size_t cut = SIZE_MAX;
  const auto entered = on_job(context, "Watch", request->name(), [&](auto found) {
    fake_.watches_.push_back(*request);
    auto& cuts = found->second.cut_watch;
    if (!cuts.empty()) {
      cut = cuts.front();
      cuts.pop_front();
    }
    fake = found->second;
  });
  if (!entered.ok()) return entered;
  for (const v1::JobEvent& event : fake.events) {
    if (event.sequence() <= request->after_sequence()) continue;
    if (cut-- == 0) return kLost;
    writer->Write(event);
  }
  while (fake.hold_watch && !context->IsCancelled())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return grpc::Status::OK;
}

grpc::Status FakeJobsService::Download(Context* context, const v1::DownloadRequest* request,
                                       grpc::ServerWriter<v1::DownloadChunk>* writer) {
  FakeJob fake;
  std::size_t cut = SIZE_MAX;
  const auto entered = on_job(context, "Download", request->name(), [&](auto found) {
    fake_.downloads_.push_back(*request);
    auto& cuts = found->second.cut_download;
    if (!cuts.empty()) {
      cut = cuts.front();
      cuts.pop_front();
    }
    fake = found->second;
  });
  if (!entered.ok()) return entered;
  const std::size_t end =
      std::min(fake.file.size(), request->offset_bytes() + std::min(cut, fake.file.size()));
  for (std::size_t at = request->offset_bytes(); at < end; at += kChunk_bytes) {
    v1::DownloadChunk chunk;
    if (at == request->offset_bytes()) *chunk.mutable_artifact() = fake.job.result();
    chunk.set_offset_bytes(at);
    chunk.set_data(fake.file.substr(at, std::min(kChunk_bytes, end - at)));
    writer->Write(chunk);
  }
  return end < fake.file.size() ? kLost : grpc::Status::OK;
}

grpc::Status FakeJobsService::GetServerInfo(Context* context, const v1::GetServerInfoRequest*,
                                            v1::GetServerInfoResponse* response) {
  const std::lock_guard lock(fake_.mutex_);
  if (auto status = enter(context, "GetServerInfo"); !status.ok()) return status;
  response->set_version("0.0-fake");
  response->set_workers(2);
  return leave("GetServerInfo");
}

grpc::Status FakeWorkersService::List(grpc::ServerContext*, const v1::ListWorkersRequest*,
                                      v1::ListWorkersResponse* response) {
  auto* worker = response->add_workers();
  worker->set_worker_id("w1");
  worker->set_state("connected");
  worker->set_slots(2);
  worker->add_tasks("tasks/7");
  return grpc::Status::OK;
}

struct FakeServer::Services {
  explicit Services(FakeJobs& fake) : jobs(fake) {}
  FakeJobsService jobs;
  FakeWorkersService workers;
  std::unique_ptr<grpc::Server> server;
};

FakeServer::FakeServer(const std::string& directory)
    : address_("unix:" + directory + "/fake.sock"), services_(std::make_unique<Services>(jobs_)) {
  start();
}

FakeServer::~FakeServer() {
  stop();
}

void FakeServer::start() {
  // Never shut down: that can wait ten seconds for a helper that polls for a blocked write.
  static const bool initialised = [] {
    grpc_init();
    return true;
  }();
  (void)initialised;
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
  builder.RegisterService(&services_->jobs);
  builder.RegisterService(&services_->workers);
  services_->server = builder.BuildAndStart();
}

void FakeServer::stop() {
  services_->server->Shutdown(std::chrono::system_clock::now());
  services_->server->Wait();
}

void FakeServer::restart() {
  stop();
  start();
}

void FakeServer::set_serving(bool serving) {
  services_->server->GetHealthCheckService()->SetServingStatus(serving);
}

}  // namespace granary::test
