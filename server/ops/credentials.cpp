#include "server/ops/credentials.h"

#include <grpcpp/security/auth_metadata_processor.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <fstream>
#include <mutex>
#include <sstream>

#include "server/ops/access.h"

namespace granary::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBearer = "Bearer ";

Result<std::string> read_file(const fs::path& path, const char* option) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return Error{ErrorCode::failed_precondition, std::string(option) + ": cannot read " + path.string(), option};
  return text.str();
}

// Follows the file: a token is withdrawn by deleting its line.
class TokenFile {
 public:
  explicit TokenFile(fs::path path) : path_(std::move(path)) {}

  Status reload() {
    std::error_code ignored;
    time_ = fs::last_write_time(path_, ignored);
    auto text = read_file(path_, "--tokens");
    if (!text) return text.error();
    auto table = TokenTable::parse(*text, path_.string());
    if (!table) return table.error();
    table_ = std::move(*table);
    return Done{};
  }

  std::optional<TokenOwner> find(std::string_view token) {
    std::lock_guard lock(mutex_);
    std::error_code error;
    if (fs::last_write_time(path_, error) != time_ && !error)
      if (Status status = reload(); !status)
        spdlog::error("event=tokens_not_reloaded reason=\"{}\"", status.error().message);
    return table_.find(token, std::chrono::duration_cast<std::chrono::seconds>(
                                  std::chrono::system_clock::now().time_since_epoch())
                                  .count());
  }

 private:
  fs::path path_;
  std::mutex mutex_;
  fs::file_time_type time_;
  TokenTable table_;
};

class TokenCheck : public grpc::AuthMetadataProcessor {
 public:
  TokenCheck(std::unique_ptr<TokenFile> tokens, RefusedCall refused)
      : tokens_(std::move(tokens)), refused_(std::move(refused)) {}

  bool IsBlocking() const override { return false; }

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context,
                       OutputMetadata* consumed, OutputMetadata*) override {
    const auto path_entry = metadata.find(":path");
    const std::string path =
        path_entry == metadata.end() ? "" : std::string(path_entry->second.data(), path_entry->second.size());
    if (is_open(path)) return grpc::Status::OK;
    const auto entry = metadata.find("authorization");
    if (entry == metadata.end()) {
      refused_("", path, "UNAUTHENTICATED");
      return {grpc::StatusCode::UNAUTHENTICATED, "this server needs a token (--token-file)"};
    }
    const std::string value(entry->second.data(), entry->second.size());
    const auto owner = value.rfind(kBearer, 0) == 0 ? tokens_->find(std::string_view(value).substr(kBearer.size()))
                                                    : std::nullopt;
    if (!owner) {
      refused_("", path, "UNAUTHENTICATED");
      return {grpc::StatusCode::UNAUTHENTICATED, "the token is unknown or has expired"};
    }
    if (!may_call(owner->role, path)) {
      spdlog::warn("event=refused owner={} role={} call={}", owner->owner, role_name(owner->role), path);
      refused_(owner->owner, path, "PERMISSION_DENIED");
      return {grpc::StatusCode::PERMISSION_DENIED,
              "role " + std::string(role_name(owner->role)) + " may not call " + path};
    }
    consumed->insert({"authorization", value});  // no handler and no log ever sees it
    context->AddProperty("granary-owner", owner->owner);
    context->SetPeerIdentityPropertyName("granary-owner");
    return grpc::Status::OK;
  }

 private:
  std::unique_ptr<TokenFile> tokens_;
  RefusedCall refused_;
};

Result<std::shared_ptr<grpc::ServerCredentials>> tls_credentials(const AccessConfig& config) {
  auto certificate = read_file(config.tls_certificate, "--tls-cert");
  if (!certificate) return certificate.error();
  auto key = read_file(config.tls_key, "--tls-key");
  if (!key) return key.error();
  grpc::SslServerCredentialsOptions options;
  options.pem_key_cert_pairs.push_back({*key, *certificate});
  return grpc::SslServerCredentials(options);
}

}  // namespace

Result<std::shared_ptr<grpc::ServerCredentials>> make_credentials(const AccessConfig& config,
                                                                  const std::string& address,
                                                                  RefusedCall refused) {
  std::shared_ptr<grpc::ServerCredentials> credentials;
  if (config.has_tls()) {
    auto tls = tls_credentials(config);
    if (!tls) return tls.error();
    credentials = *tls;
  } else if (config.has_tokens()) {
    // Plain text that gRPC knows to stay on this machine: it lets tokens be checked there too.
    const bool is_socket = address.rfind("unix:", 0) == 0;
    credentials = grpc::experimental::LocalServerCredentials(is_socket ? UDS : LOCAL_TCP);
  } else {
    return grpc::InsecureServerCredentials();
  }
  if (config.has_tokens()) {
    auto tokens = std::make_unique<TokenFile>(config.tokens);
    if (Status status = tokens->reload(); !status) return status.error();
    credentials->SetAuthMetadataProcessor(std::make_shared<TokenCheck>(std::move(tokens), std::move(refused)));
  }
  return credentials;
}

}  // namespace granary::server
