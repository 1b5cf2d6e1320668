// The door for read-only SQL: a connection of its own per query, opened read-only, that knows only
// the documented views. SQLite's authorizer refuses everything else when the statement is compiled;
// time, memory and rows are limited while it runs. Safe to call from several threads at once.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "proto/contract/result.h"
#include "server/store/query_views.h"

namespace granary::server {

struct QueryLimits {
  double time_s = 10;
  std::uint64_t rows = 100'000;
};
inline constexpr double kMaxQueryTime_s = 60;
inline constexpr std::uint64_t kMaxQueryRows = 10'000'000;
// SQLite's memory beyond what it had at the start, for all queries together.
inline constexpr std::int64_t kQueryMemoryBytes = 256ll << 20;

using Blob = std::vector<char>;
using Cell = std::variant<std::monostate, std::int64_t, double, std::string, Blob>;

class RowSink {
 public:
  virtual ~RowSink() = default;
  virtual void columns(const std::vector<std::string>& names) = 0;
  virtual bool row(std::vector<Cell> cells) = 0;  // false: nobody reads any more
};

// INVALID_ARGUMENT: not one well-formed SELECT over the views. PERMISSION_DENIED: it does more than
// reading them. DEADLINE_EXCEEDED, RESOURCE_EXHAUSTED: stopped at a limit. CANCELLED: `cancelled`.
Status run_query(const std::filesystem::path& database, const std::string& sql,
                 const QueryLimits& limits, RowSink& sink, const std::atomic<bool>& cancelled);

// The views as they are now: value columns grow with what jobs have reported.
std::vector<ViewText> list_views(const std::filesystem::path& database);

}  // namespace granary::server
