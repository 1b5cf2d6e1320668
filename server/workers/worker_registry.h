// The workers that are or were connected, their slots, and how to reach them. Lives on the owner
// thread; a WorkerLink may be called from it at any time and must not block.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "granary/v1/worker.pb.h"

namespace granary::server {

// One open Synchronize stream.
class WorkerLink {
 public:
  virtual ~WorkerLink() = default;
  virtual void send(v1::ServerMessage message) = 0;  // queued; lost when the stream has broken
  virtual void close() = 0;
};

struct Worker {
  v1::WorkerHello hello;
  std::shared_ptr<WorkerLink> link;  // null when lost
  bool draining = false;
  std::int64_t seen_ms = 0;  // steady
};

class WorkerRegistry {
 public:
  // A worker that connects again replaces its old link, which is returned (may be null).
  std::shared_ptr<WorkerLink> connect(const v1::WorkerHello& hello,
                                      std::shared_ptr<WorkerLink> link, std::int64_t now_ms);
  // False when `link` is not this worker's present one: it has come back meanwhile.
  bool disconnect(const std::string& worker_id, const WorkerLink* link);
  void seen(const std::string& worker_id, std::int64_t now_ms);
  void set_draining(const std::string& worker_id, bool draining);
  void forget_older_than(std::int64_t steady_ms);  // lost workers only

  Worker* find(const std::string& worker_id);
  std::map<std::string, Worker>& all() { return workers_; }

 private:
  std::map<std::string, Worker> workers_;
};

}  // namespace granary::server
