// What the verbs on jobs share: their names as arguments, and a job as a row.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/commands/command_line.h"
#include "granary/v1/job.pb.h"

namespace granary::commands {

// JOB.. of a verb: "jobs/12" or "12"; "-" reads names from stdin, one a line.
using JobNames = std::vector<std::string>;
void add_job_names(CLI::App& verb, JobNames& names);

// "12" -> "jobs/12"; INVALID_ARGUMENT for what cannot be a job name.
Result<std::string> job_name(const std::string& text);

// Runs `act` for each job. A failure is printed and the next job is tried; the exit code is the
// first one that is not ok.
using JobAction = std::function<Outcome(session::Session&, const std::string& name)>;
Outcome for_each_job(Context& context, const JobNames& names, const JobAction& act);

// Rows of jobs: every column for csv and json (named as in the SQL views), a few for people.
render::Table job_table(const std::vector<v1::Job>& jobs, render::Format format);

// A verb that does one thing to each of its jobs and prints the jobs as they are afterwards.
using JobChange = Result<v1::Job> (session::Session::*)(const std::string& name);
Outcome change_jobs(Context& context, const JobNames& names, JobChange change);

}  // namespace granary::commands
