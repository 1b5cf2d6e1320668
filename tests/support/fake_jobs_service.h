// A Jobs server under the test's control: real gRPC on a Unix socket, no physics and no database. A
// test scripts what each job says and where streams break, and reads afterwards what was asked.
// (gRPC itself stays in the source file: it costs every test five seconds of compilation.)
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "granary/v1/job.pb.h"
#include "proto/contract/result.h"

namespace granary::test {

struct FakeJob {
  v1::Job job;
  v1::GetValuesResponse values;
  std::vector<v1::JobEvent> events;      // what Watch tells
  std::deque<std::size_t> cut_watch;     // each Watch stream breaks after this many events, in turn
  bool hold_watch = false;               // after the last event the stream stays open
  std::string file;                      // what Download sends
  std::deque<std::size_t> cut_download;  // each Download breaks after this many bytes, in turn
  std::vector<std::string> logs;
};

class FakeServer;

// The script and the record. Methods are named as in the proto: "Submit", "Get", ...
class FakeJobs {
 public:
  FakeJob& add(const std::string& name, v1::JobState state = v1::COMPLETE);
  FakeJob& operator[](const std::string& name) { return jobs_.at(name); }
  // The next `count` calls of `method` are carried out, then answered UNAVAILABLE: a lost reply.
  void lose_replies(const std::string& method, int count);
  // Every call from now on.
  void fail(const std::string& method, ErrorCode code, const std::string& message);
  void expect_token(const std::string& token) { token_ = token; }

  std::vector<v1::SubmitJobsRequest> submissions();
  std::vector<v1::WatchJobRequest> watches();
  std::vector<v1::DownloadRequest> downloads();
  int calls(const std::string& method);

 private:
  friend class FakeJobsService;  // plays the script

  std::mutex mutex_;
  std::map<std::string, FakeJob> jobs_;
  std::map<std::string, std::vector<std::string>> by_request_id_;
  std::map<std::string, int> calls_;
  std::map<std::string, int> lost_replies_;
  std::map<std::string, std::pair<ErrorCode, std::string>> failures_;
  std::vector<v1::SubmitJobsRequest> submissions_;
  std::vector<v1::WatchJobRequest> watches_;
  std::vector<v1::DownloadRequest> downloads_;
  std::string token_;
};

// Jobs, Workers (one worker, listed) and health on a socket in `directory`.
class FakeServer {
 public:
  explicit FakeServer(const std::string& directory);
  ~FakeServer();
  const std::string& address() const { return address_; }
  FakeJobs& jobs() { return jobs_; }
  void set_serving(bool serving);
  // Breaks every connection and listens again.
  void restart();

 private:
  struct Services;
  void start();
  void stop();
  std::string address_;
  FakeJobs jobs_;
  std::unique_ptr<Services> services_;
};

v1::JobEvent state_event(std::uint64_t sequence, v1::JobState state);
v1::JobEvent progress_event(std::uint64_t sequence, double fraction);

}  // namespace granary::test
