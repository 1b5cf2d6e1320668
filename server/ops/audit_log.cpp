#include "server/ops/audit_log.h"

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

namespace granary::server {
namespace {

std::string utc_time(std::int64_t ms) {
  const std::time_t seconds = ms / 1000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[40];
  const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text + length, sizeof text - length, ".%03dZ", static_cast<int>(ms % 1000));
  return text;
}

}  // namespace

std::string audit_line(const AuditEntry& entry) {
  using Json = nlohmann::ordered_json;
  return Json{{"time", utc_time(entry.time_ms)}, {"owner", entry.owner},   {"peer", entry.peer},
              {"call", entry.call},              {"target", entry.target}, {"outcome", entry.outcome}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

AuditLog::AuditLog(std::filesystem::path file, std::uintmax_t rotate_bytes)
    : file_(std::move(file)), rotate_bytes_(rotate_bytes) {}

void AuditLog::append(const AuditEntry& entry) {
  const std::string line = audit_line(entry) + "\n";
  std::lock_guard lock(mutex_);
  std::error_code error;
  if (std::filesystem::file_size(file_, error) > rotate_bytes_ && !error) {
    std::filesystem::path old = file_;
    std::filesystem::rename(file_, old += ".1", error);
  }
  std::ofstream(file_, std::ios::app) << line;
}

}  // namespace granary::server
