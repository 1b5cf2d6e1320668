#include "server/api/study_messages.h"

#include <nlohmann/json.hpp>

namespace granary::server {
namespace {

void add_job(const JobRecord& job, JobStore& jobs, v1::Trial& trial) {
  trial.set_state(job.state);
  trial.set_error(job.error);
  trial.set_reused(job.reused);
  if (job.state != v1::COMPLETE) return;
  if (const auto result = jobs.find_result(job.id)) {
    *trial.mutable_values() = result->values();
    trial.set_cpu_s(result->cost().cpu_s());
  }
}

}  // namespace

v1::Trial to_message(const TrialRecord& record, JobStore& jobs) {
  v1::Trial trial;
  trial.set_study(study_name(record.study));
  trial.set_number(record.number);
  trial.set_label(record.label);
  trial.set_role(record.role);
  trial.set_candidate(record.candidate);
  const auto inputs = nlohmann::json::parse(record.inputs);
  for (const auto& [path, value] : inputs.items())
    (*trial.mutable_inputs())[path] = value.get<std::string>();
  if (record.objective) trial.set_objective(*record.objective);
  if (record.objective_error) trial.set_objective_error(*record.objective_error);
  if (record.feasible) trial.set_feasible(*record.feasible);
  if (record.best_objective) trial.set_best_objective(*record.best_objective);
  trial.set_pareto(record.pareto);
  trial.set_state(v1::ERROR);
  trial.set_error(record.error);
  if (record.job == 0) return trial;
  trial.set_job(job_name(record.job));
  if (const auto job = jobs.find_job(record.job))
    add_job(*job, jobs, trial);
  else
    trial.set_error("its job was deleted");
  return trial;
}

}  // namespace granary::server
