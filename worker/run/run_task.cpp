#include "worker/run/run_task.h"

#include <algorithm>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "worker/run/cost_clock.h"
#include "worker/run/frame_schedule.h"
#include "worker/run/pacing.h"
#include "worker/run/progress_meter.h"
#include "worker/run/result_builder.h"
#include "worker/run/run_record.h"
#include "worker/run/run_storage.h"
#include "worker/run/sentinels.h"
#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

// Adds its lifetime to the CPU seconds spent on output.
class OutputTimer {
 public:
  explicit OutputTimer(double& total_s) : total_s_(total_s) {}
  ~OutputTimer() { total_s_ += timer_.cpu_s(); }

 private:
  double& total_s_;
  CostTimer timer_;
};

enum class Ending { finished, rejected, cancelled, released, timed_out };

class TaskRun {
 public:
  TaskRun(const TaskSpec& spec, const SimulationFactory& factory, const TaskCallbacks& callbacks,
          const StopSignal& stop, storage::FileSystem& files)
      : spec_(spec), factory_(factory), callbacks_(callbacks), stop_(stop), files_(files),
        storage_(files, spec, callbacks.log),
        schedule_(spec.scene.output()),
        checkpoints_(spec.checkpoint_interval_s, wall_now_s()),
        meter_(replicate_count(), wall_now_s()) {}

  TaskOutcome execute() {
    auto resumed = storage_.resume();
    if (resumed) resume_from(std::move(*resumed));
    while (record_.finished.size() < replicate_count()) {
      if (!simulation_) start_replicate();
      const Ending ending = run_replicate();
      if (ending == Ending::rejected) return unstable();
      if (ending != Ending::finished) return stopped(ending);
      finish_replicate();
    }
    return complete();
  }

 private:
  std::uint32_t replicate_count() const {
    return spec_.scene.replicates() > 1 ? spec_.scene.replicates() : 1;
  }
  std::uint32_t replicate() const { return static_cast<std::uint32_t>(record_.finished.size()); }
  bool keeps_frames() const { return storage_.active() && record_.finished.empty(); }

  // ---- beginning

  void resume_from(RunStorage::Resumed resumed) {
    try {
      record_ = std::move(resumed.record);
      schedule_.restore(record_.frames);
      simulation_ = make_simulation(nullptr);
      simulation_->restore(resumed.engine);
      now_ = simulation_->progress();
      callbacks_.log("resumed at t = " + std::to_string(now_.time_s) + " s");
    } catch (const std::runtime_error& error) {
      callbacks_.log(std::string("checkpoint not usable, starting over: ") + error.what());
      storage_.start_over();
      record_ = {};
      schedule_.restore({});
      simulation_.reset();
    }
    particle_steps_before_ = simulation_ ? now_.particle_steps : 0;
    engine_wall_before_s_ = record_.costs.engine_wall_s;
  }

  void start_replicate() {
    // A filling is of one seed: the others make their own.
    const auto filling =
        replicate() == 0 ? load_filling(files_, spec_, callbacks_.log) : std::nullopt;
    simulation_ = make_simulation(filling ? &filling->state : nullptr);
    if (filling) record_.costs.reused_s += filling->cpu_s;
    filling_done_ = filling.has_value();
    now_ = simulation_->progress();
    chunk_ = {};
    particle_steps_before_ = 0;
  }

  std::unique_ptr<core::Simulation> make_simulation(const core::State* filling) {
    v1::Scene scene = spec_.scene;
    scene.set_seed(replicate_seed(spec_.scene.seed(), replicate()));
    auto simulation = factory_(scene, filling);
    if (!simulation) throw std::runtime_error("no engine for this kind of scene");
    return simulation;
  }

  // ---- one replicate

  Ending run_replicate() {
    for (;;) {
      keep_due_frame();
      if (rejection_) return Ending::rejected;
      if (const auto ending = stop_asked_for()) return *ending;
      if (checkpoints_.due(wall_now_s())) save_checkpoint();
      if (meter_.due(wall_now_s())) report_progress();
      switch (advance_chunk()) {
        case core::AdvanceStatus::advanced: break;
        case core::AdvanceStatus::finished: return close_replicate();
        case core::AdvanceStatus::rejected: return Ending::rejected;
      }
    }
  }

  core::AdvanceStatus advance_chunk() {
    const double limit_s =
        keeps_frames() ? schedule_.limit_s() : std::numeric_limits<double>::infinity();
    const CostTimer timer;
    const core::AdvanceOutcome outcome = simulation_->advance(limit_s, chunk_.steps());
    const std::uint64_t steps = note_chunk(timer);
    if (outcome.status == core::AdvanceStatus::advanced && steps == 0)
      throw std::logic_error("the engine does not advance");
    if (outcome.status == core::AdvanceStatus::rejected) rejection_ = outcome.rejection;
    else if (!check_energies()) return core::AdvanceStatus::rejected;
    keep_filling();
    return outcome.status;
  }

  // Books what the chunk cost; returns its steps.
  std::uint64_t note_chunk(const CostTimer& timer) {
    const double seconds = timer.wall_s();
    record_.costs.engine_wall_s += seconds;
    record_.costs.engine_cpu_s += timer.cpu_s();
    const core::SimulationProgress before = std::exchange(now_, simulation_->progress());
    if (now_.particles > 0)
      record_.costs.contacts_per_particle_sum +=
          static_cast<double>(now_.particle_steps - before.particle_steps) *
          static_cast<double>(now_.contacts) / static_cast<double>(now_.particles);
    const std::uint64_t steps = now_.steps - before.steps;
    chunk_.note(steps, seconds);
    return steps;
  }

  bool check_energies() {
    if (ledger_is_finite(simulation_->ledger())) {
      last_good_ledger_ = simulation_->ledger();
      return true;
    }
    const auto where = find_non_finite(simulation_->physical_state());
    rejection_ = rejection_of(where.value_or(NonFinite{"an energy", 0}), now_.time_s);
    return false;
  }

  void keep_due_frame() {
    if (!keeps_frames()) return;
    schedule_.update(now_.time_s, now_.end_time_s);
    if (schedule_.due(now_.time_s)) keep_frame();
  }

  void keep_frame() {
    const OutputTimer timer(output_cpu_s_);
    const std::vector<core::ColumnView> columns = wanted_columns(simulation_->frame());
    if (const auto where = find_non_finite(columns)) {
      rejection_ = rejection_of(*where, now_.time_s);
      return;
    }
    storage_.append_frame({schedule_.state().next_index, now_.time_s, now_.phase, columns});
    schedule_.taken(now_.time_s);
  }

  std::vector<core::ColumnView> wanted_columns(std::vector<core::ColumnView> columns) const {
    const auto& fields = spec_.scene.output().fields();
    if (!fields.empty())
      std::erase_if(columns, [&](const core::ColumnView& column) {
        return std::find(fields.begin(), fields.end(), column.name) == fields.end();
      });
    return columns;
  }

  std::optional<Ending> stop_asked_for() const {
    switch (stop_.load(std::memory_order_relaxed)) {
      case StopRequest::cancel: return Ending::cancelled;
      case StopRequest::release: return Ending::released;
      case StopRequest::none: break;
    }
    const bool late = spec_.time_limit_s > 0 && costs_so_far().wall_s > spec_.time_limit_s;
    return late ? std::optional(Ending::timed_out) : std::nullopt;
  }

  // The scenario is over: the last state is kept, and must be made of numbers.
  Ending close_replicate() {
    keep_due_frame();
    if (keeps_frames() && !rejection_ && schedule_.final_frame_due(now_.time_s)) keep_frame();
    if (const auto where = find_non_finite(simulation_->physical_state()))
      rejection_ = rejection_of(*where, now_.time_s);
    return rejection_ ? Ending::rejected : Ending::finished;
  }

  void finish_replicate() {
    report_progress();
    core::Observation observation = simulation_->observe();
    const auto withheld = withhold_non_finite(observation.values);
    observation.warnings.insert(observation.warnings.end(), withheld.begin(), withheld.end());
    fold_simulation();
    record_.finished.push_back({replicate_seed(spec_.scene.seed(), replicate()),
                                core::hash_columns(simulation_->physical_state()),
                                observation.values, simulation_->ledger()});
    if (record_.finished.size() == 1) record_.first = std::move(observation);
    simulation_.reset();
  }

  // Counters of a simulation that goes away are added to the task's.
  void fold_simulation() {
    record_.costs.steps += now_.steps;
    record_.costs.particle_steps += now_.particle_steps;
    particle_steps_done_ += now_.particle_steps - particle_steps_before_;
    for (const core::PhaseSeconds& phase : simulation_->profile()) add_phase(phase);
  }

  void add_phase(const core::PhaseSeconds& phase) {
    for (core::PhaseSeconds& known : profile_) {
      if (known.phase != phase.phase) continue;
      known.seconds += phase.seconds;
      return;
    }
    profile_.push_back(phase);
  }

  // ---- on the way

  void report_progress() {
    const std::uint64_t particle_steps =
        particle_steps_done_ + now_.particle_steps - particle_steps_before_;
    v1::Progress progress =
        meter_.take(now_, replicate(), wall_now_s(),
                    record_.costs.engine_wall_s - engine_wall_before_s_, particle_steps);
    progress.set_ledger_remainder_ratio(last_good_ledger_.remainder_ratio());
    callbacks_.progress(progress);
  }

  void save_checkpoint() {
    const OutputTimer output(output_cpu_s_);
    const CostTimer timer;
    RunRecord record = record_;
    record.frames = schedule_.state();
    record.costs = costs_so_far();
    storage_.save(record, simulation_->snapshot());
    checkpoints_.note(wall_now_s(), timer.wall_s());
  }

  void keep_filling() {
    if (filling_done_ || replicate() > 0 || spec_.filling_key.empty() ||
        spec_.filling_output.empty())
      return;
    const auto filling = simulation_->stored_filling();
    if (!filling) return;
    save_filling(files_, spec_, {*filling, costs_so_far().cpu_s});
    filling_done_ = true;
  }

  RunCosts costs_so_far() const {
    RunCosts costs = record_.costs;
    costs.wall_s += timer_.wall_s();
    costs.cpu_s += timer_.cpu_s();
    costs.peak_rss_bytes = std::max(costs.peak_rss_bytes, peak_rss_bytes());
    return costs;
  }

  // ---- endings

  TaskOutcome complete() {
    RunReport report;
    report.values = combine_values(record_.finished);
    report.state_hash = combine_state_hashes(record_.finished);
    report.ledger = worst_ledger(record_.finished);
    report.warnings = record_.first.warnings;
    return publish(report, v1::TaskFinished::COMPLETE);
  }

  TaskOutcome unstable() {
    RunReport report;
    report.state = "unstable";
    report.message = describe(rejection_.value_or(core::Rejection{}));
    report.ledger = last_good_ledger_;
    fold_simulation();
    TaskOutcome outcome = publish(report, v1::TaskFinished::UNSTABLE);
    outcome.message = report.message;
    return outcome;
  }

  TaskOutcome publish(const RunReport& report, v1::TaskFinished::Outcome how) {
    record_.costs = costs_so_far();
    TaskOutcome outcome;
    outcome.outcome = how;
    outcome.result = result_message(spec_, record_, report);
    if (storage_.active()) {
      const OutputTimer output(output_cpu_s_);
      storage_.publish(result_content(spec_, record_, report, outcome.result));
      outcome.published = true;
    }
    add_phase({"output", output_cpu_s_});
    outcome.profile = profile_;
    return outcome;
  }

  TaskOutcome stopped(Ending ending) {
    TaskOutcome outcome;
    switch (ending) {
      case Ending::released:
        save_checkpoint();
        outcome.outcome = v1::TaskFinished::RELEASED;
        outcome.message = "stopped with a checkpoint";
        break;
      case Ending::timed_out:
        outcome.outcome = v1::TaskFinished::TIMED_OUT;
        outcome.message = "time limit of " + std::to_string(spec_.time_limit_s) + " s reached";
        break;
      default:
        outcome.outcome = v1::TaskFinished::CANCELLED;
        outcome.message = "cancelled";
    }
    return outcome;
  }

  const TaskSpec& spec_;
  const SimulationFactory& factory_;
  const TaskCallbacks& callbacks_;
  const StopSignal& stop_;
  storage::FileSystem& files_;

  CostTimer timer_;  // of this attempt
  RunStorage storage_;
  FrameSchedule schedule_;
  ChunkPacer chunk_;
  CheckpointPacer checkpoints_;
  ProgressMeter meter_;

  RunRecord record_;
  std::unique_ptr<core::Simulation> simulation_;
  core::SimulationProgress now_;  // of simulation_; asking is not free
  std::optional<core::Rejection> rejection_;
  core::EnergyLedger last_good_ledger_;
  bool filling_done_ = false;
  std::uint64_t particle_steps_done_ = 0;    // in this attempt, replicates before this one
  std::uint64_t particle_steps_before_ = 0;  // of this replicate, in earlier attempts
  double engine_wall_before_s_ = 0;          // in earlier attempts
  double output_cpu_s_ = 0;  // frames, checkpoints and the result file, in this attempt
  std::vector<core::PhaseSeconds> profile_;
};

TaskOutcome failed(v1::TaskFinished::Outcome outcome, const std::string& message) {
  TaskOutcome result;
  result.outcome = outcome;
  result.message = message;
  return result;
}

}  // namespace

TaskOutcome run_task(const TaskSpec& spec, const SimulationFactory& factory,
                     const TaskCallbacks& callbacks, const StopSignal& stop,
                     storage::FileSystem& files) {
  try {
    return TaskRun(spec, factory, callbacks, stop, files).execute();
  } catch (const storage::StorageError& error) {
    return failed(v1::TaskFinished::CRASHED, error.what());
  } catch (const std::bad_alloc&) {
    return failed(v1::TaskFinished::ERROR, "out of memory");
  } catch (const std::exception& error) {
    return failed(v1::TaskFinished::ERROR, error.what());
  }
}

void remove_run_files(storage::FileSystem& files, const storage::Path& work_directory) {
  storage::remove_checkpoints(files, work_directory);
  storage::FrameStore(files, work_directory, {}, {}).clear();
}

}  // namespace granary::run
