// The server as every part of the agent calls it: one channel, one stub, the token on each call.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "granary/v1/worker.grpc.pb.h"
#include "proto/contract/result.h"

namespace granary::agent {

struct ServerAccess {
  std::string address;     // "unix:PATH" or "HOST:PORT"
  std::string tls_ca_pem;  // empty: no TLS
  std::string token;       // empty: none
};

class ServerPeer {
 public:
  explicit ServerPeer(const ServerAccess& access);

  v1::Workers::Stub& stub() const { return *stub_; }
  std::shared_ptr<grpc::ClientContext> context() const;  // carries the token

 private:
  std::string token_;
  std::unique_ptr<v1::Workers::Stub> stub_;
};

// Reads certificate and token files; a token is never sent in clear text to another machine.
Result<ServerAccess> read_access(const std::string& address, const std::string& tls_ca_file,
                                 const std::string& token_file);

}  // namespace granary::agent
