#include "server/jobs/watch_hub.h"

namespace granary::server {

void WatchHub::subscribe(JobId job, std::shared_ptr<Watcher> watcher) {
  watchers_[job].push_back(std::move(watcher));
}

void WatchHub::unsubscribe(JobId job, const Watcher* watcher) {
  const auto found = watchers_.find(job);
  if (found == watchers_.end()) return;
  std::erase_if(found->second, [&](const auto& entry) { return entry.get() == watcher; });
  if (found->second.empty()) watchers_.erase(found);
}

void WatchHub::publish(JobId job, const v1::JobEvent& event) {
  const auto found = watchers_.find(job);
  if (found == watchers_.end()) return;
  for (const auto& watcher : found->second) watcher->deliver(event);
}

void WatchHub::finish(JobId job) {
  const auto node = watchers_.extract(job);
  if (node.empty()) return;
  for (const auto& watcher : node.mapped()) watcher->finish();
}

const v1::JobEvent* WatchHub::progress(JobId job) const {
  const auto found = progress_.find(job);
  return found == progress_.end() ? nullptr : &found->second;
}

std::size_t WatchHub::watcher_count() const {
  std::size_t count = 0;
  for (const auto& [job, watchers] : watchers_) count += watchers.size();
  return count;
}

}  // namespace granary::server
