// The whole server in one object: store, dispatcher, services, listening, idle exit and drain.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "proto/contract/result.h"
#include "server/ops/credentials.h"

namespace granary::server {

struct ServerConfig {
  std::filesystem::path data;
  std::string listen;      // check_listen_address()
  double idle_exit_s = 0;  // 0 = stay
  std::uint64_t kept_free_bytes = 200ull << 20;  // intake stops below
  std::string metrics;       // HOST:PORT on this machine; empty = not served
  std::uint32_t keep_days = 0;     // ended jobs are removed after this; 0 = kept for ever
  std::uint32_t audit_one_in = 0;  // reused results computed again and compared; 0 = none
  double max_jobs_per_s = 20'000;  // submissions of one owner; ten seconds of it in one burst
  AccessConfig access;
};

class Server {
 public:
  // Opens the data directory, migrates, listens. The error says what to change.
  static Result<std::unique_ptr<Server>> start(const ServerConfig& config);
  virtual ~Server() = default;

  virtual std::string address() const = 0;      // with the port that was chosen
  virtual std::string metrics_url() const = 0;  // empty: not served
  virtual bool wants_to_exit() const = 0;   // idle for idle_exit_s
  virtual void drain() = 0;                 // NOT_SERVING, end streams, finish what was accepted
};

}  // namespace granary::server
