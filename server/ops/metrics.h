// What an operator watches, in the text format that Prometheus and OpenMetrics collectors read, on a
// loopback address of its own. Names carry their unit; counters end in _total.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "proto/contract/result.h"

namespace granary::server {

struct QueueReading {
  std::uint64_t waiting = 0, running = 0;
  std::uint64_t workers = 0, slots = 0, free_slots = 0;
  std::uint64_t disk_free_bytes = 0;
  bool accepting = true;
  std::uint64_t running_studies = 0;
  std::map<std::string, std::uint64_t> executions_ended;  // by outcome, since the start
  std::map<std::string, std::uint64_t> audits_ended;      // "same" and "different", since the start
};

class Metrics {
 public:
  // `address`: HOST:PORT on this machine (port 0 = any), or empty: collected, not served.
  static Result<std::unique_ptr<Metrics>> start(const std::string& address);
  virtual ~Metrics() = default;

  // From any thread.
  virtual void call_ended(const std::string& call, const std::string& code, double seconds) = 0;
  virtual void committed(double seconds, bool ok) = 0;
  virtual void set(const QueueReading& reading) = 0;

  virtual std::string url() const = 0;  // empty when not served
};

}  // namespace granary::server
