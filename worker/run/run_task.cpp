#include "worker/run/run_task.h"

#include <algorithm>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

#include "worker/run/cost_clock.h"
#include "worker/run/frame_keeper.h"
#include "worker/run/pacing.h"
#include "worker/run/progress_line.h"
#include "worker/run/progress_meter.h"
#include "worker/run/result_builder.h"
#include "worker/run/run_storage.h"
#include "worker/run/sentinels.h"
#include "worker/run/series_message.h"
#include "worker/run/watched_engine.h"
#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

enum class Ending { finished, rejected, cancelled, released, timed_out };

class TaskRun {
 public:
  TaskRun(const TaskSpec& spec, const SimulationFactory& factory, const TaskCallbacks& callbacks,
          const StopSignal& stop, storage::FileSystem& files)
      : spec_(spec),
        factory_(factory),
        callbacks_(callbacks),
        stop_(stop),
        files_(files),
        storage_(files, spec, callbacks.log),
        frames_(spec.scene.output(), storage_),
        checkpoints_(spec.checkpoint_interval_s, wall_now_s()),
        meter_(replicate_count(), wall_now_s()) {}

  TaskOutcome execute() {
    if (auto resumed = storage_.resume()) resume_from(std::move(*resumed));
    while (record_.finished.size() < replicate_count()) {
      if (!engine_) start_replicate();
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
      frames_.restore(record_.frames);
      const auto filling =
          replicate() == 0 ? load_filling(files_, spec_, callbacks_.log) : std::nullopt;
      auto simulation = make_simulation(filling ? &filling->state : nullptr);
      for (const core::Remedy remedy : active_remedies(record_.recoveries))
        simulation->apply(remedy);
      simulation->restore(resumed.engine);
      engine_.emplace(std::move(simulation), record_.costs);
      engine_->set_mark(record_.mark, std::move(resumed.mark));
      callbacks_.log("resumed at t = " + std::to_string(engine_->now().time_s) + " s");
    } catch (const std::exception& error) {
      callbacks_.log(std::string("checkpoint not usable, starting over: ") + error.what());
      storage_.start_over();
      record_ = {};
      frames_.restore({});
    }
    engine_wall_before_s_ = record_.costs.engine_wall_s;
  }

  void start_replicate() {
    // A filling is of one seed: the others make their own.
    const auto filling =
        replicate() == 0 ? load_filling(files_, spec_, callbacks_.log) : std::nullopt;
    if (filling) record_.costs.reused_s += filling->cpu_s;
    filling_done_ = filling.has_value();
    engine_.emplace(make_simulation(filling ? &filling->state : nullptr), record_.costs);
    record_.recoveries.clear();
    set_mark();
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
      const Ending ending = run_until_tripped();
      if (ending != Ending::rejected || !recover()) return ending;
    }
  }

  Ending run_until_tripped() {
    for (;;) {
      if (engine_->mark_due()) {
        if (!engine_->is_sound()) return Ending::rejected;
        set_mark();
      }
      if (keeps_frames() && !frames_.keep_due(*engine_)) return Ending::rejected;
      if (const auto ending = stop_asked_for()) return *ending;
      if (checkpoint_is_due()) save_checkpoint();
      if (meter_.due(wall_now_s())) report_progress();
      switch (engine_->advance(limit_s())) {
        case core::AdvanceStatus::advanced:
          break;
        case core::AdvanceStatus::finished:
          return close_replicate();
        case core::AdvanceStatus::rejected:
          return Ending::rejected;
      }
      keep_filling();
    }
  }

  double limit_s() const {
    return keeps_frames() ? frames_.limit_s() : std::numeric_limits<double>::infinity();
  }

  std::optional<Ending> stop_asked_for() const {
    switch (stop_.load(std::memory_order_relaxed)) {
      case StopRequest::cancel:
        return Ending::cancelled;
      case StopRequest::release:
        return Ending::released;
      case StopRequest::none:
        break;
    }
    const bool late = spec_.time_limit_s > 0 && costs_so_far().wall_s > spec_.time_limit_s;
    return late ? std::optional(Ending::timed_out) : std::nullopt;
  }

  // The scenario is over: the last state is kept, and must be made of numbers.
  Ending close_replicate() {
    keep_filling();
    if (!engine_->is_sound()) return Ending::rejected;
    if (keeps_frames() && !frames_.keep_last(*engine_)) return Ending::rejected;
    const bool accepted = engine_->accepts(engine_->simulation().physical_state());
    return accepted ? Ending::finished : Ending::rejected;
  }

  void finish_replicate() {
    report_progress(1.0);  // an engine's own measure may end just short of it
    core::Simulation& simulation = engine_->simulation();
    core::Observation observation = simulation.observe();
    const auto withheld = withhold_non_finite(observation.values);
    observation.warnings.insert(observation.warnings.end(), withheld.begin(), withheld.end());
    record_.finished.push_back({replicate_seed(spec_.scene.seed(), replicate()),
                                core::hash_columns(simulation.physical_state()), observation.values,
                                simulation.ledger()});
    if (record_.finished.size() == 1) record_.first = std::move(observation);
    fold_engine();
  }

  // Counters of an engine that goes away are added to the task's.
  void fold_engine() {
    record_.costs.steps += engine_->now().steps;
    record_.costs.particle_steps += engine_->now().particle_steps;
    particle_steps_done_ += engine_->new_particle_steps();
    for (const core::PhaseSeconds& phase : engine_->simulation().profile()) add_phase(phase);
    engine_.reset();
  }

  void add_phase(const core::PhaseSeconds& phase) {
    const auto known = std::find_if(profile_.begin(), profile_.end(),
                                    [&](const auto& other) { return other.phase == phase.phase; });
    if (known == profile_.end())
      profile_.push_back(phase);
    else
      known->seconds += phase.seconds;
  }

  // ---- recovery

  void set_mark() { engine_->set_mark(frames_.state()); }

  // Back to the last mark, or to the very beginning, with one setting changed; false when there is
  // nothing left to try.
  bool recover() {
    const core::Rejection rejection = *engine_->rejection();
    const auto remedy = next_remedy(rejection.cause, record_.recoveries, engine_->simulation());
    if (!remedy) return false;
    const double back_to_s = engine_->mark().time_s;
    record_.recoveries.push_back({rejection.cause, *remedy});
    const core::SettingChange change = starts_over(*remedy) ? start_over() : go_back(*remedy);
    record_.notes.push_back(note_of(rejection, change, *remedy, back_to_s));
    callbacks_.log("recovery: " + record_.notes.back().path + " = " +
                   std::to_string(record_.notes.back().value) + ": " +
                   record_.notes.back().evidence);
    return true;
  }

  core::SettingChange go_back(core::Remedy remedy) {
    const FrameSchedule::State frames = engine_->mark().frames;
    if (keeps_frames()) {
      frames_.restore(frames);
      storage_.drop_frames_from(frames.next_index);
    }
    return engine_->go_back(remedy);
  }

  core::SettingChange start_over() {
    fold_engine();
    if (keeps_frames()) {
      frames_.restore({});
      storage_.drop_frames_from(0);
    }
    auto simulation = make_simulation(nullptr);
    core::SettingChange change;
    for (const core::Remedy remedy : active_remedies(record_.recoveries))
      change = simulation->apply(remedy);
    engine_.emplace(std::move(simulation), record_.costs);
    set_mark();
    return change;
  }

  // ---- on the way

  void report_progress(double least_fraction = 0) {
    core::SimulationProgress now = engine_->now();
    now.fraction = std::max(now.fraction, least_fraction);
    v1::Progress progress = meter_.take(now, replicate(), wall_now_s(),
                                        record_.costs.engine_wall_s - engine_wall_before_s_,
                                        particle_steps_done_ + engine_->new_particle_steps());
    progress.set_ledger_remainder_ratio(engine_->last_good_ledger().remainder_ratio());
    callbacks_.progress(progress);
  }

  // Preferably at a mark, where the state is saved once instead of twice.
  bool checkpoint_is_due() const {
    const double now_s = wall_now_s();
    return checkpoints_.due(now_s) && (engine_->at_mark() || checkpoints_.overdue(now_s));
  }

  void save_checkpoint() {
    const AddedCpuTime output(output_cpu_s_);
    const CostTimer timer;
    RunRecord record = record_;
    record.frames = frames_.state();
    record.costs = costs_so_far();
    record.mark = engine_->mark();
    storage_.save(record, engine_->simulation().snapshot(),
                  engine_->at_mark() ? nullptr : &engine_->mark_state());
    checkpoints_.note(wall_now_s(), timer.wall_s());
  }

  void keep_filling() {
    if (filling_done_ || replicate() > 0 || spec_.filling_key.empty() ||
        spec_.filling_output.empty())
      return;
    if (!record_.recoveries.empty()) return;  // not what its key promises
    const auto filling = engine_->simulation().stored_filling();
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
    add_error_parts(report.values, spec_.error_parts);
    report.state_hash = combine_state_hashes(record_.finished);
    report.ledger = worst_ledger(record_.finished);
    report.warnings = record_.first.warnings;
    warn_of_trouble(report);
    TaskOutcome outcome = publish(report, v1::TaskFinished::COMPLETE);
    outcome.series = series_message(record_.first.series);
    return outcome;
  }

  void warn_of_trouble(RunReport& report) const {
    for (const RecoveryNote& note : record_.notes)
      report.warnings.push_back("recovered: " + note.path + ": " + note.evidence);
    if (report.ledger.remainder_ratio() > kSuspectRemainder)
      report.warnings.push_back("the energy ledger does not close: " +
                                std::to_string(100 * report.ledger.remainder_ratio()) +
                                " % of the energy exchanged is missing");
  }

  TaskOutcome unstable() {
    RunReport report;
    report.state = "unstable";
    core::Rejection rejection = *engine_->rejection();
    if (rejection.suggestion.empty())
      rejection.suggestion = std::string("a smaller ") +
                             (spec_.scene.has_chute() ? "chute" : "discharge") + ".time_step_s";
    report.message = describe(rejection);
    for (const RecoveryNote& note : record_.notes)
      report.warnings.push_back("recovery tried: " + note.path + ": " + note.evidence);
    report.ledger = engine_->last_good_ledger();
    fold_engine();
    TaskOutcome outcome = publish(report, v1::TaskFinished::UNSTABLE);
    outcome.message = report.message;
    return outcome;
  }

  TaskOutcome publish(const RunReport& report, v1::TaskFinished::Outcome how) {
    record_.costs = costs_so_far();
    record_.costs.wall_s += spec_.earlier_wall_s;
    record_.costs.cpu_s += spec_.earlier_cpu_s;
    TaskOutcome outcome;
    outcome.outcome = how;
    outcome.result = result_message(spec_, record_, report);
    if (storage_.active()) {
      const AddedCpuTime output(output_cpu_s_);
      storage_.publish(result_content(spec_, record_, report, outcome.result));
      outcome.published = true;
    }
    add_phase({"output", output_cpu_s_ + frames_.output_cpu_s()});
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
        outcome.message = "time limit of " + duration_text(spec_.time_limit_s) + " reached";
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
  FrameKeeper frames_;
  CheckpointPacer checkpoints_;
  ProgressMeter meter_;

  RunRecord record_;
  std::optional<WatchedEngine> engine_;  // of the replicate that is running
  bool filling_done_ = false;
  std::uint64_t particle_steps_done_ = 0;  // in this attempt, by replicates before this one
  double engine_wall_before_s_ = 0;        // in earlier attempts
  double output_cpu_s_ = 0;                // of checkpoints and the result file, in this attempt
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
