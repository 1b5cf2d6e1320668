#include "worker/agent/server_link.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace granary::agent {

namespace {

// Trying again would be refused again.
bool is_final(grpc::StatusCode code) {
  return code == grpc::StatusCode::FAILED_PRECONDITION || code == grpc::StatusCode::UNAUTHENTICATED ||
         code == grpc::StatusCode::PERMISSION_DENIED;
}

}  // namespace

ServerLink::ServerLink(const ServerPeer& server, Callbacks callbacks)
    : callbacks_(std::move(callbacks)), server_(server) {}

bool ServerLink::run() {
  double wait_s = 0.1;
  while (!stopping_) {
    welcomed_ = false;
    const grpc::Status status = run_stream();
    if (stopping_) break;
    if (is_final(status.error_code())) {
      spdlog::error("event=refused reason=\"{}\"", status.error_message());
      return false;
    }
    if (welcomed_) wait_s = 0.1;
    spdlog::warn("event=disconnected code={} reason=\"{}\" retry_s={}",
                 static_cast<int>(status.error_code()), status.error_message(), wait_s);
    if (!pause(wait_s)) break;
    wait_s = std::min(2.0, 2 * wait_s);
  }
  return true;
}

grpc::Status ServerLink::run_stream() {
  auto context = server_.context();
  std::unique_ptr<Stream> stream = server_.stub().Synchronize(context.get());
  v1::WorkerMessage greeting;
  *greeting.mutable_hello() = callbacks_.hello();
  bool open = false;
  {
    std::lock_guard lock(mutex_);
    if (stopping_) context->TryCancel();
    context_ = context;
    open = stream->Write(greeting);
    if (open) stream_ = stream.get();
  }
  v1::ServerMessage message;
  while (open && stream->Read(&message)) {
    if (message.has_welcome()) welcomed_ = true;
    callbacks_.receive(message);
  }
  {
    std::lock_guard lock(mutex_);
    stream_ = nullptr;
    context_.reset();
  }
  return stream->Finish();
}

void ServerLink::send(const v1::WorkerMessage& message) {
  std::lock_guard lock(mutex_);
  if (stream_) stream_->Write(message);
}

void ServerLink::stop() {
  stopping_ = true;
  std::lock_guard lock(mutex_);
  if (context_) context_->TryCancel();
}

bool ServerLink::pause(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!stopping_ && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return !stopping_;
}

}  // namespace granary::agent
