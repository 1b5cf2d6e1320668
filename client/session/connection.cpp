#include "client/session/connection.h"

#include <google/protobuf/wrappers.pb.h>
#include <grpc/grpc.h>
#include <grpcpp/generic/generic_stub.h>

#include <future>

#include "proto/contract/version.h"

namespace granary::session {
namespace {

constexpr int kLargestMessage_bytes = 64 << 20;  // logs and lists of many jobs

// On the wire the health messages are a string in field 1 and an enum in field 1, which is what
// these two well-known types are; Debian ships no generated code for the health service.
using HealthRequest = google::protobuf::StringValue;
using HealthResponse = google::protobuf::Int32Value;
constexpr int kServing = 1;

// Keeps gRPC initialised until the process ends. Shutting it down with the last channel can take
// ten seconds: a helper that polls for a blocked write (a large batch) is waited for.
void keep_grpc_running() {
  [[maybe_unused]] static const bool started = [] {
    grpc_init();
    return true;
  }();
}

std::shared_ptr<grpc::Channel> make_channel(const Endpoint& endpoint) {
  grpc::ChannelArguments arguments;
  arguments.SetUserAgentPrefix(std::string("granary/") + kProductVersion);
  arguments.SetMaxReceiveMessageSize(kLargestMessage_bytes);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 1000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  // A half-open connection is found in 40 s. Servers may answer more
  // frequent pings on a quiet stream with GOAWAY.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  // Each Connection owns its sockets: a fresh one never inherits another's reconnect backoff.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // An HTTP proxy has no business between a client and its granary.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  auto credentials = grpc::InsecureChannelCredentials();
  if (!endpoint.tls_ca_pem.empty()) {
    grpc::SslCredentialsOptions options;
    options.pem_root_certs = endpoint.tls_ca_pem;
    credentials = grpc::SslCredentials(options);
  }
  return grpc::CreateCustomChannel(endpoint.address, credentials, arguments);
}

// READY, or the first TRANSIENT_FAILURE, or the deadline: an absent server answers at once.
bool becomes_ready(grpc::Channel& channel, std::chrono::system_clock::time_point deadline) {
  for (auto state = channel.GetState(true); state != GRPC_CHANNEL_READY;
       state = channel.GetState(true)) {
    if (state == GRPC_CHANNEL_TRANSIENT_FAILURE || state == GRPC_CHANNEL_SHUTDOWN) return false;
    if (!channel.WaitForStateChange(state, deadline)) return false;
  }
  return true;
}

}  // namespace

Error error_from(const grpc::Status& status) {
  std::string message = status.error_message();
  if (message.empty()) message = to_string(static_cast<ErrorCode>(status.error_code()));
  return {static_cast<ErrorCode>(status.error_code()), message, ""};
}

Connection::Connection(const Endpoint& endpoint, std::shared_ptr<grpc::Channel> channel)
    : address_(endpoint.address),
      token_(endpoint.token),
      channel_(std::move(channel)),
      jobs_(v1::Jobs::NewStub(channel_)),
      workers_(v1::Workers::NewStub(channel_)),
      studies_(v1::Studies::NewStub(channel_)),
      query_(v1::Query::NewStub(channel_)),
      admin_(v1::Admin::NewStub(channel_)) {}

Result<std::shared_ptr<Connection>> Connection::open(const Endpoint& endpoint,
                                                     std::chrono::milliseconds timeout) {
  keep_grpc_running();
  auto channel = make_channel(endpoint);
  if (!becomes_ready(*channel, std::chrono::system_clock::now() + timeout))
    return Error{ErrorCode::unavailable, "no server answers at " + endpoint.address, ""};
  return std::shared_ptr<Connection>(new Connection(endpoint, std::move(channel)));
}

std::unique_ptr<grpc::ClientContext> Connection::stream_context() const {
  auto context = std::make_unique<grpc::ClientContext>();
  if (!token_.empty()) context->AddMetadata("authorization", "Bearer " + token_);
  return context;
}

std::unique_ptr<grpc::ClientContext> Connection::call_context() const {
  auto context = stream_context();
  context->set_deadline(std::chrono::system_clock::now() + kCallTimeout);
  return context;
}

Status Connection::check_health(std::chrono::milliseconds timeout) const {
  grpc::TemplatedGenericStub<HealthRequest, HealthResponse> stub(channel_);
  auto context = stream_context();
  context->set_deadline(std::chrono::system_clock::now() + timeout);
  HealthRequest request;
  HealthResponse response;
  std::promise<grpc::Status> answered;
  stub.UnaryCall(context.get(), "/grpc.health.v1.Health/Check", grpc::StubOptions(), &request,
                 &response, [&](grpc::Status status) { answered.set_value(std::move(status)); });
  const grpc::Status status = answered.get_future().get();
  if (!status.ok()) return error_from(status);
  if (response.value() != kServing)
    return Error{ErrorCode::unavailable, "the server at " + address_ + " is not serving", ""};
  return Done{};
}

}  // namespace granary::session
