// granary health: is the server there and serving?
#include "client/commands/catalogue.h"

namespace granary::commands {
namespace {

Outcome show_health(Context& context) {
  auto session = context.session();
  if (!session) return session.error();
  const Status serving = (*session)->health();
  if (!serving) return serving.error();
  // Whether it serves is for everybody; what it does is for those with a token.
  auto info = (*session)->server_info();
  if (!info && info.error().code == ErrorCode::unauthenticated) info = v1::GetServerInfoResponse();
  if (!info) return info.error();
  const render::Table table{
      {"server", "status", "version", "engine_version", "waiting", "running", "workers", "slots"},
      {{(*session)->address(), "serving", info->version(), info->engine_version(), info->waiting(),
        info->running(), info->workers(), info->slots()}}};
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_health(CommandLine& line) {
  line.on(line.verb("health", "Ask the server whether it serves",
                    "granary health --server grain.example:7443"),
          show_health);
}

}  // namespace granary::commands
