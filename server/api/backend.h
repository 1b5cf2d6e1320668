// What every service of the API stands on, and the way onto the owner thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include <grpcpp/grpcpp.h>

#include "server/artifacts/artifact_store.h"
#include "server/jobs/dispatcher.h"
#include "server/jobs/rate_limit.h"
#include "server/store/owner_thread.h"
#include "server/studies/study_director.h"

namespace granary::server {

Now system_now();

struct Backend {
  OwnerThread& owner;
  Dispatcher& dispatcher;  // owner thread only
  JobStore& store;         // owner thread only
  ArtifactStore& artifacts;
  StudyDirector& studies;   // owner thread only
  StudyStore& study_store;  // owner thread only
  RateLimit& submissions;  // jobs by owner
  std::atomic<std::int64_t> last_use_ms{
      0};  // steady; users only, workers do not keep a server alive

  void touch() { last_use_ms = system_now().steady_ms; }
};

// Who holds the token of this call; without tokens everybody on this machine is "local".
std::string owner_of(const grpc::CallbackServerContext& context);

grpc::Status to_grpc(const Status& status);
// The same, with the delay after which to ask again, if there is one, in trailing metadata under gRPC's
// own name ("grpc-retry-pushback-ms").
grpc::Status to_grpc(const Status& status, grpc::CallbackServerContext* context);

// Answers a unary call from the owner thread: `work` fills the response inside the transaction, the
// reply leaves after the commit.
grpc::ServerUnaryReactor* answer_on_owner(Backend& backend, grpc::CallbackServerContext* context,
                                          std::function<Status()> work);
// The same for `work` that changes nothing: it does not wait behind what is to be committed.
grpc::ServerUnaryReactor* look_on_owner(Backend& backend, grpc::CallbackServerContext* context,
                                        std::function<Status()> work);

}  // namespace granary::server
