// One gRPC channel to one server, with its token. gRPC types stay inside client/session.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>

#include "granary/v1/admin.grpc.pb.h"
#include "granary/v1/job.grpc.pb.h"
#include "granary/v1/query.grpc.pb.h"
#include "granary/v1/study.grpc.pb.h"
#include "granary/v1/worker.grpc.pb.h"
#include "proto/contract/result.h"

namespace granary::session {

struct Endpoint {
  std::string address;     // unix:PATH or HOST:PORT
  std::string tls_ca_pem;  // empty: no TLS
  std::string token;       // empty: none
};

inline constexpr std::chrono::milliseconds kConnectTimeout{1500};
inline constexpr std::chrono::seconds kCallTimeout{60};

class Connection {
 public:
  // Waits for a working channel; UNAVAILABLE at the first refusal or after the timeout.
  static Result<std::shared_ptr<Connection>> open(const Endpoint& endpoint,
                                                  std::chrono::milliseconds timeout);

  // A context that carries the token; without a deadline for streams.
  std::unique_ptr<grpc::ClientContext> stream_context() const;
  std::unique_ptr<grpc::ClientContext> call_context() const;

  // SERVING by the standard health service; otherwise why not.
  Status check_health(std::chrono::milliseconds timeout) const;

  v1::Jobs::Stub& jobs() { return *jobs_; }
  v1::Workers::Stub& workers() { return *workers_; }
  v1::Studies::Stub& studies() { return *studies_; }
  v1::Query::Stub& query() { return *query_; }
  v1::Admin::Stub& admin() { return *admin_; }
  const std::string& address() const { return address_; }

 private:
  Connection(const Endpoint& endpoint, std::shared_ptr<grpc::Channel> channel);

  std::string address_;
  std::string token_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::Jobs::Stub> jobs_;
  std::unique_ptr<v1::Workers::Stub> workers_;
  std::unique_ptr<v1::Studies::Stub> studies_;
  std::unique_ptr<v1::Query::Stub> query_;
  std::unique_ptr<v1::Admin::Stub> admin_;
};

Error error_from(const grpc::Status& status);

}  // namespace granary::session
