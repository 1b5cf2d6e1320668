// Who watches which job. State changes come from the database and are delivered in order, each
// once; progress is only the latest. Lives on the owner thread; a Watcher must not block.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "granary/v1/job.pb.h"
#include "server/jobs/records.h"

namespace granary::server {

class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual void deliver(const v1::JobEvent& event) = 0;
  virtual void finish() = 0;  // no more events will come
};

class WatchHub {
 public:
  void subscribe(JobId job, std::shared_ptr<Watcher> watcher);
  void unsubscribe(JobId job, const Watcher* watcher);
  void publish(JobId job, const v1::JobEvent& event);
  void finish(JobId job);  // after the final state

  void set_progress(JobId job, const v1::JobEvent& event) { progress_[job] = event; }
  const v1::JobEvent* progress(JobId job) const;
  void forget_progress(JobId job) { progress_.erase(job); }

  std::size_t watcher_count() const;

 private:
  std::unordered_map<JobId, std::vector<std::shared_ptr<Watcher>>> watchers_;
  std::unordered_map<JobId, v1::JobEvent> progress_;  // running jobs only
};

}  // namespace granary::server
