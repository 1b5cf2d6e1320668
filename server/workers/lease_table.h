// Leases: which task is held by which worker until when. In memory only; the database knows the
// assignments, so after a restart every open task gets a full lease to be claimed again in. Pure:
// steady-clock milliseconds are an argument, so a jump of the wall clock changes nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace granary::server {

inline constexpr std::int64_t kLeaseMs = 15'000;  // silence after which a task is given to others
inline constexpr std::int64_t kHeartbeatMs = 2'000;
// A broken stream is most often a dead worker: it has this long to come back.
inline constexpr std::int64_t kReconnectMs = 4'000;

struct Lease {
  std::int64_t task = 0;
  std::int64_t job = 0;
  std::string worker;
  std::int64_t expires_ms = 0;
};

class LeaseTable {
 public:
  void grant(std::int64_t task, std::int64_t job, const std::string& worker, std::int64_t now_ms);
  // False when the task is not leased, or to another worker: its result must be refused.
  bool renew(std::int64_t task, const std::string& worker, std::int64_t now_ms);
  void shorten(const std::string& worker, std::int64_t now_ms);
  void end(std::int64_t task);
  void clear();

  const Lease* find(std::int64_t task) const;
  std::vector<Lease> of_worker(const std::string& worker) const;
  std::vector<Lease> expired(std::int64_t now_ms) const;
  std::uint32_t count_of(const std::string& worker) const;
  std::size_t size() const { return leases_.size(); }

 private:
  std::unordered_map<std::int64_t, Lease> leases_;
  std::unordered_map<std::string, std::uint32_t> per_worker_;
};

}  // namespace granary::server
