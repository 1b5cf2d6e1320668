// granaryd: wiring only.
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <thread>

#include "proto/contract/version.h"
#include "server/ops/access.h"
#include "server/ops/server.h"

namespace {

volatile std::sig_atomic_t stop_signal = 0;
void on_signal(int signal) {
  stop_signal = signal;
}

std::filesystem::path default_data() {
  if (const char* data = std::getenv("GRANARY_DATA")) return data;
  if (const char* data = std::getenv("XDG_DATA_HOME"))
    return std::filesystem::path(data) / "granary";
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home ? home : ".") / ".local/share/granary";
}

struct TokenRequest {
  std::string file, role, owner;
  int days = 0;
};

int add_token(const TokenRequest& request) {
  using namespace granary::server;
  const auto role = role_from(request.role);
  if (!role || request.owner.empty() || request.owner.find_first_of(" \t\n#") != std::string::npos) {
    std::fprintf(stderr, "granaryd: --role must be read, submit, worker or admin; --owner one word\n");
    return 2;
  }
  TokenOwner owner{*role, request.owner, 0};
  if (request.days > 0) owner.expires_s = std::time(nullptr) + 86'400LL * request.days;
  const NewToken made = make_token(owner);
  std::ofstream file(request.file, std::ios::app);
  file << made.line << '\n';
  if (!file.flush()) {
    std::fprintf(stderr, "granaryd: cannot write %s\n", request.file.c_str());
    return 2;
  }
  std::printf("%s\n", made.token.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  using granary::server::Server;
  CLI::App app{
      "granaryd: the Granary server\n\nExample: granaryd --data /var/lib/granary --listen "
      "127.0.0.1:7420"};
  granary::server::ServerConfig config;
  config.data = default_data();
  config.listen = "127.0.0.1:7420";
  std::string log_level = "info";
  app.add_option("--data", config.data, "data directory (database, artifacts)")
      ->capture_default_str();
  app.add_option("--listen", config.listen, "127.0.0.1:PORT (0 = any) or unix:PATH")
      ->capture_default_str();
  app.add_option("--idle-exit", config.idle_exit_s,
                 "leave after this many seconds without use; 0 = stay");
  app.add_option_function<std::uint64_t>(
         "--keep-free-mb", [&config](std::uint64_t megabytes) { config.kept_free_bytes = megabytes << 20; },
         "accept nothing new when less is free on the disk of --data")
      ->default_str("200");
  app.add_option("--keep-days", config.keep_days,
                 "remove jobs and their files this many days after they ended, but for those "
                 "tagged keep; 0 = never")
      ->check(CLI::Range(0, 36500));
  app.add_option(
      "--audit-reuse", config.audit_one_in,
      "compute one in so many reused results again, at the lowest priority, and compare; 0 = none");
  app.add_option("--metrics", config.metrics, "serve metrics (Prometheus text) on this loopback HOST:PORT; 0 = any port");
  app.add_option("--max-jobs-per-s", config.max_jobs_per_s, "submissions one owner may send, ten seconds of it at once")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--tls-cert", config.access.tls_certificate, "certificate chain (PEM, with subjectAltName)");
  app.add_option("--tls-key", config.access.tls_key, "its private key (PEM)");
  app.add_option("--tokens", config.access.tokens, "file of access tokens; made by `granaryd token`");
  auto& token = *app.add_subcommand("token", "add a token to a file and print it; only its hash is kept");
  TokenRequest request;
  token.add_option("--tokens", request.file, "file of access tokens")->required();
  token.add_option("--role", request.role, "read, submit, worker or admin")->required();
  token.add_option("--owner", request.owner, "name shown on jobs")->required();
  token.add_option("--days", request.days, "days until it expires; 0 = never");
  app.add_option("--log-level", log_level, "debug, info, warn, error")
      ->envname("GRANARY_LOG_LEVEL");
  app.set_version_flag("--version", std::string("granaryd ") + granary::kProductVersion);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (token.parsed()) return add_token(request);
  if (config.access.tls_certificate.empty() != config.access.tls_key.empty()) {
    std::fprintf(stderr, "granaryd: --tls-cert and --tls-key go together\n");
    return 2;
  }
  spdlog::set_default_logger(spdlog::stderr_logger_mt("granaryd"));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z level=%l %v");
  spdlog::set_level(spdlog::level::from_str(log_level));
  std::signal(SIGTERM, on_signal);
  std::signal(SIGINT, on_signal);
  std::signal(SIGPIPE, SIG_IGN);

  auto server = Server::start(config);
  if (!server) {
    std::fprintf(stderr, "granaryd: %s\n", server.error().message.c_str());
    return 2;
  }
  std::printf("listening on %s\n", (*server)->address().c_str());
  if (!(*server)->metrics_url().empty()) std::printf("metrics on %s\n", (*server)->metrics_url().c_str());
  std::fflush(stdout);
  spdlog::info("event=start address={} data={}", (*server)->address(), config.data.string());
  while (stop_signal == 0 && !(*server)->wants_to_exit())
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  spdlog::info("event=drain reason={}", stop_signal ? "signal" : "idle");
  (*server)->drain();
  spdlog::info("event=exit");
  return 0;
}
