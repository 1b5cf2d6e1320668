#include "server/workers/worker_registry.h"

#include <utility>

namespace granary::server {

std::shared_ptr<WorkerLink> WorkerRegistry::connect(const v1::WorkerHello& hello,
                                                    std::shared_ptr<WorkerLink> link,
                                                    std::int64_t now_ms) {
  Worker& worker = workers_[hello.worker_id()];
  worker.hello = hello;
  worker.draining = false;
  worker.seen_ms = now_ms;
  return std::exchange(worker.link, std::move(link));
}

bool WorkerRegistry::disconnect(const std::string& worker_id, const WorkerLink* link) {
  Worker* worker = find(worker_id);
  if (!worker || worker->link.get() != link) return false;
  worker->link.reset();
  return true;
}

void WorkerRegistry::seen(const std::string& worker_id, std::int64_t now_ms) {
  if (Worker* worker = find(worker_id)) worker->seen_ms = now_ms;
}

void WorkerRegistry::set_draining(const std::string& worker_id, bool draining) {
  if (Worker* worker = find(worker_id)) worker->draining = draining;
}

void WorkerRegistry::forget_older_than(std::int64_t steady_ms) {
  std::erase_if(workers_, [&](const auto& entry) {
    return !entry.second.link && entry.second.seen_ms < steady_ms;
  });
}

Worker* WorkerRegistry::find(const std::string& worker_id) {
  const auto found = workers_.find(worker_id);
  return found == workers_.end() ? nullptr : &found->second;
}

}  // namespace granary::server
