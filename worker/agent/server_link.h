// The stream to the server: opened again with growing pauses whenever it breaks, greeted with what
// this worker holds. Sending never fails visibly: what was lost with a broken stream is said again
// by its owner after the next welcome.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "granary/v1/worker.grpc.pb.h"
#include "worker/agent/server_peer.h"

namespace granary::agent {

class ServerLink {
 public:
  struct Callbacks {
    std::function<v1::WorkerHello()> hello;
    std::function<void(const v1::ServerMessage&)> receive;  // on the link's thread
  };

  ServerLink(const ServerPeer& server, Callbacks callbacks);

  // Connects, receives, reconnects until stop(). Returns false when the server refused this worker
  // for good (another engine version).
  bool run();
  void stop();

  // From any thread; dropped when there is no stream now.
  void send(const v1::WorkerMessage& message);

 private:
  using Stream = grpc::ClientReaderWriter<v1::WorkerMessage, v1::ServerMessage>;
  grpc::Status run_stream();
  bool pause(double seconds);

  Callbacks callbacks_;
  const ServerPeer& server_;
  std::mutex mutex_;  // guards the stream's existence and its writes
  std::shared_ptr<grpc::ClientContext> context_;
  Stream* stream_ = nullptr;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> welcomed_ = false;
};

}  // namespace granary::agent
