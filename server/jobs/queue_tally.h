// How many jobs wait and run, and for whom: kept in memory beside the database so that limits and
// idleness cost no query. Rebuilt from the store at start and after a failed commit.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "server/jobs/records.h"

namespace granary::server {

class QueueTally {
 public:
  void load(std::map<std::string, std::uint64_t> waiting_by_owner,
            std::map<QueueClass, std::uint64_t> waiting_by_class, std::uint64_t running);

  void job_waits(const std::string& owner, const QueueClass& job_class);  // submitted, requeued, retried
  void job_waits_no_more(const std::string& owner, const QueueClass& job_class);  // assigned or cancelled
  void job_runs() { ++running_; }
  void job_runs_no_more() { --running_; }

  std::uint64_t waiting() const { return waiting_; }
  std::uint64_t running() const { return running_; }
  std::uint64_t waiting_of(const std::string& owner) const;
  // Those with waiting jobs.
  const std::map<QueueClass, std::uint64_t>& classes() const { return by_class_; }

 private:
  std::map<std::string, std::uint64_t> by_owner_;
  std::map<QueueClass, std::uint64_t> by_class_;
  std::uint64_t waiting_ = 0;
  std::uint64_t running_ = 0;
};

}  // namespace granary::server
