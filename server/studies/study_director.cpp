#include "server/studies/study_director.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "proto/contract/job_state.h"
#include "server/jobs/new_job.h"

namespace granary::server {
namespace {

// Proposed and not yet told, per study: the queue stays readable and a million-point plan fits.
constexpr std::uint32_t kWindow = 1000;
// Per call of work(): a sweep that is answered from the store must not hold up the other requests.
constexpr int kStepsPerCall = 100;

Error not_found(StudyId id) {
  return {ErrorCode::not_found, "no study " + study_name(id), "name"};
}

Error wrong_state(const StudyRecord& study, const char* what) {
  return {ErrorCode::failed_precondition,
          study_name(study.id) + " is " + v1::Study::State_Name(study.state) + ": cannot " + what,
          "name"};
}

bool has_ended(const StudyRecord& study) {
  return study.state != v1::Study::RUNNING && study.state != v1::Study::PAUSED;
}

std::string json_of(const std::map<std::string, std::string>& inputs) {
  return nlohmann::json(inputs).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

v1::Study to_message(const StudyRecord& record) {
  v1::Study study;
  study.set_name(study_name(record.id));
  study.set_kind(record.kind);
  study.set_state(record.state);
  if (!record.spec_bytes.empty())
    study.mutable_spec()->ParseFromString(record.spec_bytes);
  else
    study.mutable_spec()->set_name(record.name);
  study.set_owner(record.owner);
  put_time(record.submitted_ms, study.mutable_submitted());
  if (record.ended_ms > 0) put_time(record.ended_ms, study.mutable_ended());
  study.set_planned(record.planned);
  study.set_trials(record.trials);
  study.set_ended_trials(record.told);
  study.set_failed_trials(record.failed);
  study.set_reused_trials(record.reused);
  study.set_message(record.message);
  *study.mutable_summary() = record.summary;
  return study;
}

StudyDirector::StudyDirector(StudyStore& store, JobStore& jobs, Dispatcher& dispatcher,
                             MakeGenerator make)
    : store_(store), jobs_(jobs), dispatcher_(dispatcher), make_(std::move(make)) {}

void StudyDirector::reload() {
  live_.clear();
  effects_.clear();
  to_advance_.clear();
  for (const auto state : {v1::Study::RUNNING, v1::Study::PAUSED})
    for (const StudyId id : store_.studies_in(state)) to_advance_.insert(id);
}

// ------------------------------------------------------------------------------------------- users

Result<StudyRecord> StudyDirector::submit(const NewStudy& study, Now now) {
  if (!study.request_id.empty())
    if (const auto earlier = store_.find_study_request(study.request_id)) return find(*earlier);
  auto generator = make_(study.spec);
  if (!generator) return generator.error();
  StudyRecord record;
  record.kind = kind_of(study.spec);
  record.name = study.spec.name();
  record.owner = study.owner;
  record.request_id = study.request_id;
  record.spec_bytes = study.spec.SerializeAsString();
  record.generator_bytes = (*generator)->save();
  record.submitted_ms = now.wall_ms;
  record.planned = (*generator)->planned();
  record.id = store_.insert_study(record);
  live_[record.id] = {record, study.spec, std::move(*generator)};
  to_advance_.insert(record.id);
  return record;
}

Result<StudyRecord> StudyDirector::find(StudyId id) {
  auto record = store_.find_study(id);
  if (!record) return not_found(id);
  return *record;
}

Result<StudyRecord> StudyDirector::pause(StudyId id, Now) {
  auto live = live_of(id, "pause it");
  if (!live) return live.error();
  (*live)->record.state = v1::Study::PAUSED;
  save(**live);
  return (*live)->record;
}

Result<StudyRecord> StudyDirector::resume(StudyId id, Now) {
  auto live = live_of(id, "resume it");
  if (!live) return live.error();
  (*live)->record.state = v1::Study::RUNNING;
  save(**live);
  to_advance_.insert(id);
  return (*live)->record;
}

Result<StudyRecord> StudyDirector::extend(StudyId id, std::uint32_t budget, Now) {
  auto record = store_.find_study(id);
  if (!record) return not_found(id);
  Live* live = load(id);
  if (live == nullptr) return wrong_state(*store_.find_study(id), "extend it");
  if (Status status = live->generator->extend(budget); !status) {
    if (has_ended(live->record)) live_.erase(id);
    return status.error();
  }
  if (live->record.state == v1::Study::COMPLETE) {
    live->record.state = v1::Study::RUNNING;
    live->record.ended_ms = 0;
  }
  save(*live);
  to_advance_.insert(id);
  return live->record;
}

Result<StudyRecord> StudyDirector::cancel(StudyId id, bool keep_jobs, Now now) {
  auto record = store_.find_study(id);
  if (!record) return not_found(id);
  if (has_ended(*record)) return *record;
  auto live = live_of(id, "cancel it");
  if (!live) return live.error();
  (*live)->record.state = v1::Study::CANCELLED;
  (*live)->record.ended_ms = now.wall_ms;
  (*live)->record.message = "cancelled";
  save(**live);
  const StudyRecord cancelled = (*live)->record;
  live_.erase(id);
  to_advance_.erase(id);
  if (!keep_jobs) cancel_jobs(cancelled, now);
  return cancelled;
}

void StudyDirector::cancel_jobs(const StudyRecord& record, Now now) {
  for (const TrialRecord& trial : store_.trials_after(record.id, record.told, kWindow))
    if (trial.job != 0) (void)dispatcher_.cancel(trial.job, now);
}

Status StudyDirector::watch(StudyId id, std::shared_ptr<StudyWatcher> watcher) {
  auto record = store_.find_study(id);
  if (!record) return not_found(id);
  effects_.push_back([this, id, message = to_message(*record), ended = has_ended(*record),
                      watcher = std::move(watcher)] {
    watcher->deliver(message);
    if (ended) return watcher->finish();
    watchers_[id].push_back(watcher);
  });
  return Done{};
}

void StudyDirector::unwatch(StudyId id, const StudyWatcher* watcher) {
  const auto found = watchers_.find(id);
  if (found == watchers_.end()) return;
  std::erase_if(found->second, [&](const auto& each) { return each.get() == watcher; });
  if (found->second.empty()) watchers_.erase(found);
}

void StudyDirector::publish(const StudyRecord& record) {
  effects_.push_back(
      [this, id = record.id, message = to_message(record), ended = has_ended(record)] {
        const auto found = watchers_.find(id);
        if (found == watchers_.end()) return;
        for (const auto& watcher : found->second) {
          watcher->deliver(message);
          if (ended) watcher->finish();
        }
        if (ended) watchers_.erase(found);
      });
}

// ---------------------------------------------------------------------------------------- progress

void StudyDirector::work(Now now) {
  to_advance_.merge(dispatcher_.take_studies_to_advance());
  const std::set<StudyId> now_due = std::exchange(to_advance_, {});
  for (const StudyId id : now_due)
    if (Live* live = load(id)) advance(*live, now);
}

Result<StudyDirector::Live*> StudyDirector::live_of(StudyId id, const char* what) {
  auto record = store_.find_study(id);
  if (!record) return not_found(id);
  Live* live = has_ended(*record) ? nullptr : load(id);
  if (live == nullptr) return wrong_state(*store_.find_study(id), what);
  return live;
}

// Null when the study has ended, or cannot be continued (it is then in state ERROR).
StudyDirector::Live* StudyDirector::load(StudyId id) {
  if (const auto found = live_.find(id); found != live_.end()) return &found->second;
  auto record = store_.find_study(id);
  if (!record || record->state == v1::Study::CANCELLED || record->state == v1::Study::ERROR)
    return nullptr;
  Live live{std::move(*record), {}, nullptr};
  live.spec.ParseFromString(live.record.spec_bytes);
  auto generator = make_(live.spec);
  std::string why = generator ? "" : generator.error().message;
  if (generator) try {
      (*generator)->restore(live.record.generator_bytes);
    } catch (const std::exception& error) {
      why = error.what();
    }
  if (!why.empty()) {
    live.record.state = v1::Study::ERROR;
    live.record.message = "cannot be continued: " + why;
    store_.update_study(live.record);
    publish(live.record);
    return nullptr;
  }
  live.generator = std::move(*generator);
  return &(live_[id] = std::move(live));
}

void StudyDirector::advance(Live& live, Now now) {
  const StudyId id = live.record.id;
  if (live.record.state == v1::Study::COMPLETE) {  // a retried job has ended again
    live_.erase(id);
    return;
  }
  int steps = kStepsPerCall;
  try {
    for (; steps > 0; --steps) {
      const bool heard = tell_next(live);
      const bool asked = propose(live, 1, now);
      if (!heard && !asked) break;
    }
  } catch (const std::runtime_error&) {
    throw;                               // of the store: the whole transaction is undone
  } catch (const std::exception& bug) {  // of a generator: this study ends, the others go on
    return fail(live, bug.what(), now);
  }
  if (steps == 0) to_advance_.insert(id);
  end_if_done(live, now);
  const StudyRecord& record = live.record;
  if (steps > 0 && record.state == v1::Study::RUNNING && record.told == record.trials)
    return fail(live, "nothing is running and nothing is proposed", now);
  save(live);
  if (has_ended(live.record)) live_.erase(id);
}

bool StudyDirector::tell_next(Live& live) {
  StudyRecord& record = live.record;
  if (record.told == record.trials) return false;
  auto trial = store_.find_trial(record.id, record.told + 1);
  const auto outcome =
      trial ? outcome_of(*trial) : TrialOutcome{v1::ERROR, "", "trial is lost", {}};
  if (!outcome) return false;
  const TrialJudgement judgement = live.generator->tell(record.told + 1, *outcome);
  ++record.told;
  if (outcome->state != v1::COMPLETE) ++record.failed;
  record.summary = live.generator->summary();
  if (!trial) return true;
  trial->told = true;
  trial->objective = judgement.objective;
  trial->objective_error = judgement.objective_error;
  trial->feasible = judgement.feasible;
  if (record.summary.has_best_objective()) trial->best_objective = record.summary.best_objective();
  store_.update_trial(*trial);
  if (const auto findings = live.generator->findings()) store_.put_findings(record.id, *findings);
  return true;
}

// Nothing while its job waits or runs.
std::optional<TrialOutcome> StudyDirector::outcome_of(const TrialRecord& trial) {
  if (trial.job == 0) return TrialOutcome{v1::ERROR, "", trial.error, {}};
  const auto job = jobs_.find_job(trial.job);
  if (!job) return TrialOutcome{v1::CANCELLED, job_name(trial.job), "its job was deleted", {}};
  if (!is_final(job->state)) return {};
  TrialOutcome outcome{job->state, job_name(job->id), job->error, {}};
  if (job->state != v1::COMPLETE) return outcome;
  if (auto result = jobs_.find_result(job->id)) outcome.result = std::move(*result);
  return outcome;
}

bool StudyDirector::propose(Live& live, std::size_t limit, Now now) {
  const StudyRecord& record = live.record;
  if (record.state != v1::Study::RUNNING || record.trials - record.told >= kWindow) return false;
  std::vector<TrialProposal> proposals = live.generator->ask(limit);
  for (TrialProposal& proposal : proposals) submit_trial(live, std::move(proposal), now);
  return !proposals.empty();
}

void StudyDirector::submit_trial(Live& live, TrialProposal proposal, Now now) {
  StudyRecord& record = live.record;
  TrialRecord trial;
  trial.study = record.id;
  trial.number = ++record.trials;
  trial.label = proposal.label;
  trial.role = proposal.role;
  trial.candidate = proposal.candidate == 0 ? trial.number : proposal.candidate;
  trial.inputs = json_of(proposal.inputs);
  if (auto queued = queue(live, proposal.scene, now)) {
    trial.job = *queued;
    const auto stored = jobs_.find_job(trial.job);
    if (stored && stored->reused) ++record.reused;
  } else {
    trial.error = queued.error().message;
  }
  store_.insert_trial(trial);
}

Result<JobId> StudyDirector::queue(const Live& live, const v1::Scene& scene, Now now) {
  auto job = new_job_of(scene);
  if (!job) return job.error();
  job->tags = {live.spec.tags().begin(), live.spec.tags().end()};
  job->priority = live.spec.priority();
  job->owner = live.record.owner;
  job->time_limit_s = live.spec.time_limit_s();
  job->fresh = live.spec.fresh();
  job->study = live.record.id;
  return dispatcher_.submit_trial(std::move(*job), now);
}

void StudyDirector::fail(Live& live, const std::string& why, Now now) {
  live.record.state = v1::Study::ERROR;
  live.record.ended_ms = now.wall_ms;
  live.record.message = "internal error: " + why;
  store_.update_study(live.record);
  publish(live.record);
  live_.erase(live.record.id);
}

void StudyDirector::end_if_done(Live& live, Now now) {
  StudyRecord& record = live.record;
  if (record.told < record.trials || !live.generator->done()) return;
  record.state = v1::Study::COMPLETE;
  record.ended_ms = now.wall_ms;
}

void StudyDirector::save(Live& live) {
  live.record.planned = live.generator->planned();
  live.record.summary = live.generator->summary();
  live.record.generator_bytes = live.generator->save();
  store_.update_study(live.record);
  publish(live.record);
}

}  // namespace granary::server
