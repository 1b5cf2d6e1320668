// granary up: a server and its workers on this machine, in the foreground.
#include <cstdlib>
#include <thread>

#include "client/commands/catalogue.h"
#include "client/session/private_server.h"
#include "client/session/supervisor.h"

namespace granary::commands {
namespace {

struct UpOptions {
  int worker_count = 0;  // 0: one per core
  std::string listen;
  bool is_private = false;
};

// GRANARY_PRIVATE_IDLE_S is for tests, which cannot wait a minute for an idle server to leave.
int private_idle_exit_s() {
  const char* text = std::getenv("GRANARY_PRIVATE_IDLE_S");
  const int seconds = text ? std::atoi(text) : 0;
  return seconds > 0 ? seconds : session::kPrivateIdleExit_s;
}

Outcome up(Context& context, const UpOptions& options) {
  auto settings = context.settings();
  if (!settings) return settings.error();
  auto directory = session::DataDirectory::open((*settings)[session::SettingKey::data].value);
  if (!directory) return directory.error();
  const int core_count = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int worker_count = options.worker_count > 0 ? options.worker_count : core_count;
  session::Supervisor supervisor(*directory,
                                 {.listen = options.listen,
                                  .worker_count = worker_count,
                                  .idle_exit_s = options.is_private ? private_idle_exit_s() : 0,
                                  .log_level = (*settings)[session::SettingKey::log_level].value,
                                  .wait_for_predecessor = options.is_private},
                                 [&](std::string_view text) { context.say(text); });
  const Status ended = supervisor.run([&](const std::string& address) {
    (void)context.write(address + "\n");
    context.say("serving " + directory->path().string() + " with " + std::to_string(worker_count) +
                " workers; Ctrl-C drains");
  });
  if (!ended) return ended.error();
  return ExitCode::ok;
}

}  // namespace

void add_up(CommandLine& line) {
  auto options = std::make_shared<UpOptions>();
  CLI::App& verb =
      line.verb("up", "Start a server and workers here, in the foreground; Ctrl-C drains",
                "granary up --workers 4 --listen 127.0.0.1:7443 --data /var/lib/granary");
  verb.add_option("--workers", options->worker_count, "worker processes (default: one per core)")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  verb.add_option("--listen", options->listen,
                  "HOST:PORT or unix:PATH (default: a socket in the data directory)")
      ->type_name("ADDR");
  verb.add_flag("--private", options->is_private)->group("");  // how other verbs start it
  line.on(verb, [options](Context& context) { return up(context, *options); });
}

}  // namespace granary::commands
