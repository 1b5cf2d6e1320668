#include "worker/agent/server_peer.h"

#include <fstream>
#include <sstream>

namespace granary::agent {
namespace {

std::shared_ptr<grpc::Channel> open_channel(const ServerAccess& access) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1'000);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetMaxReceiveMessageSize(64 << 20);
  auto credentials = grpc::InsecureChannelCredentials();
  if (!access.tls_ca_pem.empty()) {
    grpc::SslCredentialsOptions options;
    options.pem_root_certs = access.tls_ca_pem;
    credentials = grpc::SslCredentials(options);
  }
  return grpc::CreateCustomChannel(access.address, credentials, arguments);
}

bool is_this_machine(const std::string& address) {
  return address.rfind("unix:", 0) == 0 || address.rfind("127.", 0) == 0 ||
         address.rfind("localhost:", 0) == 0 || address.rfind("[::1]:", 0) == 0;
}

Result<std::string> read_file(const std::string& path, const char* option) {
  if (path.empty()) return std::string();
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return Error{ErrorCode::failed_precondition, std::string(option) + ": cannot read " + path, option};
  return text.str();
}

}  // namespace

ServerPeer::ServerPeer(const ServerAccess& access)
    : token_(access.token), stub_(v1::Workers::NewStub(open_channel(access))) {}

std::shared_ptr<grpc::ClientContext> ServerPeer::context() const {
  auto context = std::make_shared<grpc::ClientContext>();
  if (!token_.empty()) context->AddMetadata("authorization", "Bearer " + token_);
  return context;
}

Result<ServerAccess> read_access(const std::string& address, const std::string& tls_ca_file,
                                 const std::string& token_file) {
  auto ca = read_file(tls_ca_file, "--tls-ca");
  if (!ca) return ca.error();
  auto token = read_file(token_file, "--token-file");
  if (!token) return token.error();
  while (!token->empty() && std::isspace(static_cast<unsigned char>(token->back()))) token->pop_back();
  if (!token->empty() && ca->empty() && !is_this_machine(address))
    return Error{ErrorCode::failed_precondition,
                 "--token-file: a token goes to another machine over TLS only, give --tls-ca", "token_file"};
  return ServerAccess{address, std::move(*ca), std::move(*token)};
}

}  // namespace granary::agent
