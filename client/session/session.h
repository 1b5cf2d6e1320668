// A conversation with a server: finds it (or starts the private one), repeats what may be repeated
// when the connection breaks, and turns every failure into an Error. Used by one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/session/interrupt.h"
#include "client/session/settings.h"
#include "granary/v1/job.pb.h"
#include "granary/v1/query.pb.h"
#include "granary/v1/study.pb.h"
#include "granary/v1/worker.pb.h"
#include "proto/contract/result.h"

namespace granary::session {

// What the user should know and no program reads; `detail` notices are for -v.
enum class NoticeLevel { normal, detail };
using Notice = std::function<void(NoticeLevel, std::string_view)>;

using EventSink = std::function<void(const v1::JobEvent&)>;
using StudySink = std::function<void(const v1::Study&)>;
using RowsSink = std::function<Status(const v1::QueryRows&)>;
using ChunkSink = std::function<Status(const v1::DownloadChunk&)>;

class Session {
 public:
  // UNAVAILABLE within two seconds when a named server is not there. No named server: the private
  // one of the data directory is joined or started.
  static Result<std::unique_ptr<Session>> open(const Settings& settings, Notice notice);
  ~Session();

  const std::string& address() const;

  // A request without request_id gets a random one, so that a repeat submits nothing twice.
  Result<std::vector<std::string>> submit(v1::SubmitJobsRequest request);
  Result<v1::Job> get(const std::string& name);
  Result<v1::ListJobsResponse> list(const v1::ListJobsRequest& request);
  Result<v1::Job> cancel(const std::string& name);
  Result<v1::Job> retry(const std::string& name);
  Status remove(const std::string& name);
  Result<v1::GetValuesResponse> values(const std::string& name);
  Result<std::vector<std::string>> logs(const std::string& name);
  Result<v1::ListWorkersResponse> workers();
  Result<v1::GetServerInfoResponse> server_info();
  Status health();

  // Hands every event to `sink` until the job has ended, over any number of broken streams, and
  // returns the ended job; nothing after an interrupt. Gives up after five minutes without contact.
  Result<std::optional<v1::Job>> watch(const std::string& name, const EventSink& sink,
                                       Interrupt& interrupt);

  // ---- studies (studies.cpp)

  // A request without request_id gets a random one, so that a repeat submits nothing twice.
  Result<v1::Study> submit_study(v1::SubmitStudyRequest request);
  Result<v1::Study> get_study(const std::string& name);
  Result<v1::ListStudiesResponse> list_studies(const v1::ListStudiesRequest& request);
  Result<v1::Study> pause_study(const std::string& name);
  Result<v1::Study> resume_study(const std::string& name);
  Result<v1::Study> extend_study(const v1::ExtendStudyRequest& request);
  Result<v1::Study> cancel_study(const v1::CancelStudyRequest& request);
  Result<std::vector<v1::Trial>> trials(const std::string& name);  // all pages
  // As watch(): the study whenever it has changed, until it has ended.
  Result<std::optional<v1::Study>> watch_study(const std::string& name, const StudySink& sink,
                                               Interrupt& interrupt);

  // ---- queries (studies.cpp). Rows that were handed on are not taken back by a later error.
  Status query(const v1::QueryRequest& request, const RowsSink& sink);
  Result<v1::GetSchemaResponse> query_schema();

  // One pass over the result file from `offset_bytes`. The caller resumes: see fetch.h.
  Status download(const std::string& name, std::uint64_t offset_bytes, const ChunkSink& sink);

  // One pass over a fresh copy of the server's database.
  Status backup(const ChunkSink& sink);

  // Before the next try after UNAVAILABLE: joins or starts the private server again when it is one.
  Status reconnect();

 private:
  class Link;
  explicit Session(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace granary::session
