// What the listening port demands: TLS from a certificate, tokens from a file, or neither on this
// machine only.
#pragma once

#include <grpcpp/security/server_credentials.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "proto/contract/result.h"

namespace granary::server {

struct AccessConfig {
  std::filesystem::path tls_certificate;  // PEM chain; its subjectAltName must name the host
  std::filesystem::path tls_key;
  std::filesystem::path tokens;

  bool has_tls() const { return !tls_certificate.empty(); }
  bool has_tokens() const { return !tokens.empty(); }
};

// A call that got no further than its token: owner ("" when unknown), path, gRPC's code. On gRPC's threads.
using RefusedCall =
    std::function<void(const std::string& owner, const std::string& path, const std::string& code)>;

// `address`: a Unix socket or a TCP address. The token file is read again when it changes.
Result<std::shared_ptr<grpc::ServerCredentials>> make_credentials(const AccessConfig& config,
                                                                  const std::string& address,
                                                                  RefusedCall refused);

}  // namespace granary::server
