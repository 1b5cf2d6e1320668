// granary workers: who computes.
#include <algorithm>

#include "client/commands/catalogue.h"

namespace granary::commands {
namespace {

std::vector<std::string> tag_list(const v1::WorkerInfo& worker) {
  std::vector<std::string> list;
  for (const auto& [name, value] : worker.tags()) list.push_back(name + "=" + value);
  std::sort(list.begin(), list.end());
  return list;
}

Outcome list_workers(Context& context) {
  auto session = context.session();
  if (!session) return session.error();
  auto response = (*session)->workers();
  if (!response) return response.error();
  render::Table table{{"worker", "host", "pid", "state", "slots", "busy", "seconds_since_seen",
                       "engine_version", "vector_path", "tags", "tasks"},
                      {}};
  for (const auto& worker : response->workers())
    table.rows.push_back({worker.worker_id(), worker.host(), worker.pid(), worker.state(),
                          worker.slots(), worker.busy(), worker.seconds_since_seen(),
                          worker.engine_version(), worker.vector_path(), tag_list(worker),
                          std::vector<std::string>(worker.tasks().begin(), worker.tasks().end())});
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_workers(CommandLine& line) {
  line.on(line.verb("workers", "List the workers of the server", "granary workers --format json"),
          list_workers);
}

}  // namespace granary::commands
