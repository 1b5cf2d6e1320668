// One task as the run layer sees it: what to compute, where to keep it, whom to tell, how it ended.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "granary/v1/result.pb.h"
#include "granary/v1/scene.pb.h"
#include "granary/v1/worker.pb.h"
#include "worker/core/simulation.h"
#include "worker/run/error_parts.h"
#include "worker/storage/file_system.h"

namespace granary::run {

// Makes the engine of a resolved scene; `filling` is a stored filling to start from, or null. May
// throw std::exception with a message for the user.
using SimulationFactory = std::function<std::unique_ptr<core::Simulation>(
    const v1::Scene& scene, const core::State* filling)>;

struct TaskSpec {
  v1::Scene scene;        // resolved
  std::string scene_key;  // hash of what decides the physics (job_key)
  std::string engine_version;
  std::string vector_path;  // "avx512", "avx2" or "portable"
  std::string host;
  std::vector<v1::Decision> decisions;
  std::map<std::string, v1::EffectReport> effects;
  std::vector<std::string> warnings;

  // Nothing is stored when `result_path` is empty. Segments and checkpoints live in
  // `work_directory` and stay there until remove_run_files().
  storage::Path result_path;
  storage::Path work_directory;
  storage::Path filling_input;   // read if it exists and has the key
  storage::Path filling_output;  // written when the engine offers its filling
  std::string filling_key;       // empty: fillings are neither read nor written

  // Of a main run after pilots (accuracy_run.h): what they found and cost.
  std::string variant;  // of the scene: checkpoints of another one are not used
  std::map<std::string, ErrorParts> error_parts;  // by value
  double earlier_cpu_s = 0;
  double earlier_wall_s = 0;

  double time_limit_s = 0;            // wall time over all attempts; 0 = none
  double checkpoint_interval_s = 20;  // wall time; stretched when checkpoints cost more than 2 %
};

enum class StopRequest { none, cancel, release };  // release: checkpoint first, to resume later

struct TaskCallbacks {
  std::function<void(const v1::Progress&)> progress = [](const v1::Progress&) {};
  std::function<void(std::string_view line)> log = [](std::string_view) {};
};

struct TaskOutcome {
  v1::TaskFinished::Outcome outcome = v1::TaskFinished::ERROR;
  std::string message;  // one line: why it did not complete
  v1::Result result;
  v1::SeriesList series;   // thinned, for the database
  bool published = false;  // the file at result_path is there, whole and durable
  std::vector<core::PhaseSeconds> profile;
};

// Set from signal handlers and other threads; read once a chunk.
using StopSignal = std::atomic<StopRequest>;
static_assert(StopSignal::is_always_lock_free, "set in signal handlers");

}  // namespace granary::run
