// A Jobs server under the test's control: real gRPC on a Unix socket, no physics and no database. A
// test scripts what each job says and where streams break, and reads afterwards what was asked.
#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "granary/v1/job.grpc.pb.h"
#include "granary/v1/worker.grpc.pb.h"

namespace granary::test {

struct FakeJob {
  v1::Job job;
  v1::GetValuesResponse values;
  std::vector<v1::JobEvent> events;     // what Watch tells
  std::deque<std::size_t> cut_watch;    // each Watch stream breaks after this many events, in turn
  bool hold_watch = false;              // after the last event the stream stays open
  std::string file;                     // what Download sends
  std::deque<std::size_t> cut_download; // each Download breaks after this many bytes, in turn
  std::vector<std::string> logs;
};

class FakeJobsService final : public v1::Jobs::Service {
 public:
  // ---- the script
  FakeJob& add(const std::string& name, v1::JobState state = v1::COMPLETE);
  // The next `count` calls of `method` are carried out, then answered UNAVAILABLE: a lost reply.
  void lose_replies(const std::string& method, int count);
  void fail(const std::string& method, grpc::Status status);  // every call from now on
  void expect_token(const std::string& token) { token_ = token; }
  FakeJob& operator[](const std::string& name) { return jobs_.at(name); }

  // ---- what was asked
  std::vector<v1::SubmitJobsRequest> submissions();
  std::vector<v1::WatchJobRequest> watches();
  std::vector<v1::DownloadRequest> downloads();
  int calls(const std::string& method);

  // ---- Jobs
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

  std::mutex mutex_;
  std::map<std::string, FakeJob> jobs_;
  std::map<std::string, std::vector<std::string>> by_request_id_;
  std::map<std::string, int> calls_;
  std::map<std::string, int> lost_replies_;
  std::map<std::string, grpc::Status> failures_;
  std::vector<v1::SubmitJobsRequest> submissions_;
  std::vector<v1::WatchJobRequest> watches_;
  std::vector<v1::DownloadRequest> downloads_;
  std::string token_;
};

class FakeWorkersService final : public v1::Workers::Service {
 public:
  grpc::Status List(grpc::ServerContext*, const v1::ListWorkersRequest*,
                    v1::ListWorkersResponse* response) override;
};

// Both services, health and a socket in `directory`.
class FakeServer {
 public:
  explicit FakeServer(const std::string& directory);
  ~FakeServer();
  const std::string& address() const { return address_; }
  FakeJobsService& jobs() { return jobs_; }
  void set_serving(bool serving);
  // Breaks every connection and listens again.
  void restart();

 private:
  void start();
  void stop();
  std::string address_;
  FakeJobsService jobs_;
  FakeWorkersService workers_;
  std::unique_ptr<grpc::Server> server_;
};

v1::JobEvent state_event(std::uint64_t sequence, v1::JobState state);
v1::JobEvent progress_event(std::uint64_t sequence, double fraction);

}  // namespace granary::test
