#include "worker/run/console.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>

#include "granary/v1/job.pb.h"
#include "proto/contract/job_state.h"
#include "proto/contract/scene_meshes.h"
#include "proto/contract/scene_text.h"
#include "proto/contract/values_json.h"
#include "worker/run/accuracy_run.h"
#include "worker/run/calibrate.h"
#include "worker/run/progress_line.h"
#include "worker/run/run_task.h"
#include "worker/run/stop_signals.h"
#include "worker/storage/salvage.h"
#include "worker/storage/storage_error.h"
#include "worker/storage/verify.h"

namespace granary::run {
namespace {

Result<std::string> read_scene_text(const std::string& file) {
  std::ifstream from_file;
  if (file != "-") from_file.open(file, std::ios::binary);
  std::istream& in = file == "-" ? std::cin : from_file;
  if (!in) return Error{ErrorCode::invalid_argument, "cannot read " + file, ""};
  std::string text(kMaxSceneBytes + 1, '\0');  // one more: too large shows without reading it all
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

Result<TaskSpec> prepare(const ConsoleOptions& options, const EngineBuild& build) {
  const Result<std::string> text = read_scene_text(options.scene_file);
  if (!text) return text.error();
  Result<v1::Scene> scene = load_scene(*text, options.scene_file, options.settings);
  if (!scene) return scene.error();
  if (const Status status = inline_meshes(*scene, options.scene_file); !status)
    return status.error();
  if (options.threads) scene->set_threads(*options.threads);
  Result<TaskSpec> spec = make_task(*scene, build);
  if (spec && !options.output_file.empty()) {
    spec->result_path = options.output_file;
    spec->work_directory = options.output_file + ".parts";
  }
  return spec;
}

v1::GetValuesResponse response_of(const ConsoleOptions& options, const TaskOutcome& outcome) {
  v1::GetValuesResponse response;
  response.set_name(options.scene_file);
  response.set_kind(outcome.result.kind());
  response.set_state(outcome.outcome == v1::TaskFinished::COMPLETE ? v1::COMPLETE : v1::UNSTABLE);
  *response.mutable_result() = outcome.result;
  response.set_error(outcome.message);
  return response;
}

void print_table(const v1::Result& result) {
  const std::map<std::string, v1::Quantity> values(result.values().begin(), result.values().end());
  for (const auto& [name, quantity] : values) {
    std::printf("%-28s ", name.c_str());
    if (quantity.has_value())
      std::printf("%.6g", quantity.value());
    else
      std::printf("unknown");
    if (quantity.has_error()) std::printf(" +- %.2g", quantity.error());
    if (quantity.unit() != "1") std::printf(" %s", quantity.unit().c_str());
    if (!quantity.has_error()) std::printf("  (%s)", quantity.error_basis().c_str());
    std::printf("\n");
  }
  const v1::Cost& cost = result.cost();
  std::printf("%-28s %.3g s wall, %.3g s CPU, %.3g ns per particle-step\n", "cost", cost.wall_s(),
              cost.cpu_s(), cost.ns_per_particle_step());
  std::printf("%-28s %.2g of the energy exchanged\n", "ledger remainder",
              result.ledger().remainder_ratio());
}

void print_profile(const TaskOutcome& outcome) {
  const v1::Cost& cost = outcome.result.cost();
  double sum_s = 0;
  std::fprintf(stderr, "%-24s %10s %7s %12s\n", "phase", "seconds", "share", "ns/part-step");
  const auto print = [&](const std::string& name, double seconds) {
    std::fprintf(stderr, "%-24s %10.4f %6.1f%% %12.3f\n", name.c_str(), seconds,
                 100 * seconds / std::max(cost.cpu_s(), 1e-12),
                 1e9 * seconds / std::max<double>(1, static_cast<double>(cost.particle_steps())));
  };
  for (const core::PhaseSeconds& phase : outcome.profile) {
    print(phase.phase, phase.seconds);
    sum_s += phase.seconds;
  }
  print("everything else", std::max(0.0, cost.cpu_s() - sum_s));
  print("task (CPU)", cost.cpu_s());
}

ExitCode exit_code_of(v1::TaskFinished::Outcome outcome) {
  switch (outcome) {
    case v1::TaskFinished::COMPLETE:
      return ExitCode::ok;
    case v1::TaskFinished::UNSTABLE:
      return ExitCode::unstable;
    case v1::TaskFinished::CANCELLED:
    case v1::TaskFinished::RELEASED:
      return ExitCode::interrupted;
    case v1::TaskFinished::TIMED_OUT:
      return ExitCode::timed_out;
    default:
      return ExitCode::job_failed;
  }
}

bool has_values(const TaskOutcome& outcome) {
  return outcome.outcome == v1::TaskFinished::COMPLETE ||
         outcome.outcome == v1::TaskFinished::UNSTABLE;
}

void discard_parts(const TaskSpec& spec) {
  if (spec.work_directory.empty()) return;
  remove_run_files(storage::real_file_system(), spec.work_directory);
  std::error_code ignored;  // someone else's file in there keeps the directory, rightly
  std::filesystem::remove(spec.work_directory, ignored);
}

void print_outcome(const ConsoleOptions& options, const TaskOutcome& outcome) {
  if (options.profile && has_values(outcome)) print_profile(outcome);
  if (!outcome.message.empty()) std::cerr << "granary-worker: " << outcome.message << '\n';
  if (outcome.outcome == v1::TaskFinished::RELEASED)
    std::cerr << "the same command goes on from there\n";
  if (!has_values(outcome)) return;
  for (const std::string& warning : outcome.result.warnings())
    std::cerr << "warning: " << warning << '\n';
  if (options.json)
    std::cout << values_json(response_of(options, outcome)) << std::endl;
  else if (outcome.outcome == v1::TaskFinished::COMPLETE)
    print_table(outcome.result);
  std::fflush(stdout);
}

}  // namespace

int run_console(const ConsoleOptions& options, const EngineBuild& build) {
  const Result<TaskSpec> spec = prepare(options, build);
  if (!spec) {
    std::cerr << "granary-worker: " << spec.error().message << '\n';
    return static_cast<int>(granary::exit_code_of(spec.error().code));
  }
  const auto stop = options.output_file.empty() ? StopRequest::cancel : StopRequest::release;
  listen_to_stop_signals(stop, stop);
  ProgressLine line(!options.quiet);
  TaskCallbacks callbacks;
  callbacks.progress = [&](const v1::Progress& progress) { line.show(progress); };
  callbacks.log = [&](std::string_view text) { line.log(std::string(text)); };
  const TaskOutcome outcome = run_request(*spec, build.factory, callbacks, stop_signal());
  line.end();
  note_speed(*spec, outcome);
  if (has_values(outcome)) discard_parts(*spec);
  print_outcome(options, outcome);
  return static_cast<int>(exit_code_of(outcome.outcome));
}

int verify_console(const std::string& file) {
  const storage::VerifyReport report = storage::verify_result(file);
  for (const std::string& problem : report.problems) std::cerr << problem << '\n';
  if (!report.ok()) return static_cast<int>(ExitCode::verification_failed);
  std::cout << file << ": " << report.dataset_count << " datasets, " << report.frame_count
            << " frames, " << report.data_bytes << " bytes of data, all intact\n";
  return 0;
}

int salvage_console(const std::string& directory, const std::string& output_file) {
  try {
    const std::uint64_t frame_count =
        storage::salvage_run(storage::real_file_system(), directory, output_file);
    std::cout << output_file << ": " << frame_count << " frames\n";
    return 0;
  } catch (const storage::StorageError& error) {
    std::cerr << "granary-worker: " << error.what() << '\n';
    return static_cast<int>(error.fault() == storage::StorageFault::missing
                                ? ExitCode::not_found
                                : ExitCode::verification_failed);
  }
}

}  // namespace granary::run
