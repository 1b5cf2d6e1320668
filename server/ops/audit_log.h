// Who changed what, and who was refused: one JSON line per call in audit.log of the data directory,
// appended, never rewritten; at 32 MB the file becomes audit.log.1. No message contents, no tokens.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>

namespace granary::server {

struct AuditEntry {
  std::int64_t time_ms = 0;  // wall clock
  std::string owner;
  std::string peer;
  std::string call;     // "Jobs/Cancel"
  std::string target;   // "jobs/17" or how many items; empty when there is none
  std::string outcome;  // gRPC's code
};

// One line without its end; every value escaped, so that no name can forge a second line.
std::string audit_line(const AuditEntry& entry);

class AuditLog {
 public:
  explicit AuditLog(std::filesystem::path file, std::uintmax_t rotate_bytes = 32u << 20);
  void append(const AuditEntry& entry);  // any thread; a full disk loses the line, never the call

 private:
  std::filesystem::path file_;
  std::uintmax_t rotate_bytes_;
  std::mutex mutex_;
};

}  // namespace granary::server
