// granary-worker as a service: holds tasks of one server, one engine process per slot.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace granary::agent {

struct AgentConfig {
  std::string server;  // "unix:PATH" or "HOST:PORT"
  std::filesystem::path token_file; // empty: none
  std::filesystem::path tls_ca;     // certificate authority (PEM); empty: no TLS
  unsigned slots = 1;
  std::filesystem::path work_dir;  // made if missing; one folder per running task
  std::filesystem::path program;   // started again as the engine
  std::string vector_path;         // of the engines: "avx512", "avx2" or "portable"
  std::vector<std::string> kinds;  // of scene that the engines can run
  std::map<std::string, std::string> tags;  // what jobs may ask for by --worker-tag
};

// Runs until SIGTERM or SIGINT, then drains: engines checkpoint, tasks go back. Returns the exit
// code: 0 after a drain, 1 when the server refused this worker.
int run_agent(const AgentConfig& config);

}  // namespace granary::agent
