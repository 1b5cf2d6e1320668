// One place that sees every call of every service when it ends: for the audit log and the metrics.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <grpcpp/support/server_interceptor.h>

namespace granary::server {

struct EndedCall {
  std::string path;    // "/granary.v1.Jobs/Submit"
  std::string target;  // the request's `name`, or "3 items"
  std::string owner;
  std::string peer;
  grpc::StatusCode code = grpc::StatusCode::OK;
  double seconds = 0;
};

// Called at the end of each call, on gRPC's threads.
using CallObserver = std::function<void(const EndedCall&)>;

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> observing(
    CallObserver observer);

// "Jobs/Submit" of "/granary.v1.Jobs/Submit".
std::string short_call(const std::string& path);
// Calls that change something or carry data away: those the audit log keeps.
bool is_audited(const std::string& path);

}  // namespace granary::server
