// granary-worker: wiring only. Serves a server (--server), runs one scene without one (--scene),
// checks a result file (--verify), saves the frames of an abandoned run (--salvage), or is the engine
// process of a worker (--engine, started by worker/agent).
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <stdexcept>

#include "proto/contract/result.h"
#include "proto/contract/scene_rules.h"
#include "proto/contract/version.h"
#include "worker/agent/agent.h"
#include "worker/run/console.h"
#include "worker/run/engine_process.h"
#include "worker/run/export_console.h"
#include "worker/run/history_console.h"
#include "worker/scene/chute.h"
#include "worker/scene/discharge.h"

namespace {

using namespace granary;

std::unique_ptr<core::Simulation> make_engine(const v1::Scene& scene, const core::State* filling) {
  if (scene.has_discharge()) return scene::make_discharge(scene, filling);
  if (scene.has_chute()) return scene::make_chute(scene, filling);
  throw std::invalid_argument("scenes of kind '" + std::string(kind_of(scene)) + "' cannot be run by this version");
}

// Both engines give the bits of the portable code on every processor (worker/dem/README.md, worker/dda), so
// any worker may continue any run.
run::EngineBuild engine_build() { return {make_engine, "portable"}; }

std::pair<std::string, std::string> split_setting(const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0)
    throw CLI::ValidationError("--set", "'" + text + "' is not path=value");
  return {text.substr(0, at), text.substr(at + 1)};
}

struct Options {
  run::ConsoleOptions console;
  std::vector<std::string> settings;
  std::string format = "table";
  std::string verify_file;
  std::string export_file;
  std::string export_form = "csv";
  std::string salvage_directory;
  std::string history_file;
  std::string engine_directory;
  int parent = 0;
  agent::AgentConfig agent;
  std::string log_level = "info";
  std::vector<std::string> tags;
};

void declare(CLI::App& app, Options& options) {
  app.set_version_flag("--version", std::string("granary-worker ") + kProductVersion + ", engine " +
                                        kEngineVersion);
  app.add_option("--server", options.agent.server, "work for this server: unix:PATH or HOST:PORT");
  app.add_option("--token-file", options.agent.token_file, "file that holds the access token")
      ->envname("GRANARY_TOKEN_FILE");
  app.add_option("--tls-ca", options.agent.tls_ca, "certificate authority (PEM): the server speaks TLS")
      ->envname("GRANARY_TLS_CA");
  app.add_option("--slots", options.agent.slots, "tasks at a time")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--tag", options.tags, "name=value that jobs may ask for by --worker-tag (repeatable)")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        const auto equals = text.find('=');
        return equals == std::string::npos || equals == 0 ? "must be name=value" : "";
      });
  app.add_option("--work-dir", options.agent.work_dir, "folder for running tasks (default: a temporary one)");
  app.add_option("--log-level", options.log_level, "debug, info, warn, error")->envname("GRANARY_LOG_LEVEL");
  app.add_option("--scene", options.console.scene_file, "run this scene without a server; - = stdin");
  app.add_option("--set", options.settings, "path=value: change one field of the scene (repeatable)")
      ->allow_extra_args(false);
  app.add_option("-o,--output", options.console.output_file, "HDF5 result file");
  app.add_option("--format", options.format, "of the values on stdout")
      ->check(CLI::IsMember({"table", "json"}))
      ->capture_default_str();
  app.add_option("--threads", options.console.threads, "threads of a chute's engine; never changes a result")
      ->check(CLI::Range(1, 256));
  app.add_flag("--profile", options.console.profile, "seconds per phase of a time step, on stderr");
  app.add_flag("-q,--quiet", options.console.quiet, "no progress");
  app.add_option("--verify", options.verify_file, "check a result file");
  app.add_option("--export", options.export_file, "write a result file in another form to the folder -o")
      ->needs("--output");
  app.add_option("--to", options.export_form, "form of --export")
      ->check(CLI::IsMember({"csv", "svg", "xyz", "paraview"}))
      ->capture_default_str();
  app.add_option("--salvage", options.salvage_directory,
                 "make a result file (-o) of the frames in the .parts of an unfinished run")
      ->needs("--output");
  app.add_option("--export-history", options.history_file,
                 "write a study's history, as the client hands it over, to the HDF5 file -o")
      ->needs("--output");
  app.add_option("--engine", options.engine_directory)->group("");
  app.add_option("--parent", options.parent)->group("");
  app.footer("Example: granary-worker --scene tests/scenes/discharge_small.txtpb --set seed=2 -o small.h5");
}

int serve(Options& options) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("granary-worker"));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z level=%l %v");
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  if (options.agent.work_dir.empty())
    options.agent.work_dir = std::filesystem::temp_directory_path() / ("granary-work-" + std::to_string(::getuid()));
  options.agent.program = std::filesystem::read_symlink("/proc/self/exe");
  for (const std::string& tag : options.tags)
    options.agent.tags[tag.substr(0, tag.find('='))] = tag.substr(tag.find('=') + 1);
  options.agent.vector_path = engine_build().vector_path;
  options.agent.kinds = {"chute", "discharge"};
  return agent::run_agent(options.agent);
}

int run_program(Options& options) {
  if (!options.engine_directory.empty())
    return run::run_engine_process(options.engine_directory, options.parent, engine_build());
  if (!options.verify_file.empty()) return run::verify_console(options.verify_file);
  if (!options.export_file.empty())
    return run::export_console(options.export_file, options.export_form, options.console.output_file);
  if (!options.history_file.empty())
    return run::history_console(options.history_file, options.console.output_file);
  if (!options.salvage_directory.empty())
    return run::salvage_console(options.salvage_directory, options.console.output_file);
  if (!options.agent.server.empty()) return serve(options);
  if (options.console.scene_file.empty()) {
    std::cerr << "granary-worker: --server ADDRESS or --scene FILE is missing (see --help)\n";
    return static_cast<int>(ExitCode::usage);
  }
  options.console.json = options.format == "json";
  return run::run_console(options.console, engine_build());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("granary-worker: the engines of Granary");
  Options options;
  declare(app, options);
  try {
    app.parse(argc, argv);
    for (const std::string& text : options.settings)
      options.console.settings.push_back(split_setting(text));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  return run_program(options);
}
