// granary ls: jobs by kind, state and tag, newest first as the server lists them.
#include <algorithm>

#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"
#include "proto/contract/job_state.h"

namespace granary::commands {
namespace {

constexpr std::uint32_t kPageSize = 500;

struct ListOptions {
  std::string kind;
  std::string state;
  std::vector<std::string> tags;
  std::uint32_t limit = 100;
};

Result<v1::ListJobsRequest> request_of(const ListOptions& options) {
  v1::ListJobsRequest request;
  request.set_kind(options.kind);
  if (!options.state.empty()) request.set_state(*job_state_from(options.state));
  for (const std::string& tag : options.tags) {
    const auto equals = tag.find('=');
    if (equals == std::string::npos || equals == 0)
      return Error{ErrorCode::invalid_argument, "--tag '" + tag + "' is not of the form name=value",
                   "tags"};
    (*request.mutable_tags())[tag.substr(0, equals)] = tag.substr(equals + 1);
  }
  return request;
}

// Pages until `limit` jobs (0 = all) are there; says when there are more.
Result<std::vector<v1::Job>> collect(Context& context, v1::ListJobsRequest request,
                                     std::uint32_t limit) {
  auto session = context.session();
  if (!session) return session.error();
  std::vector<v1::Job> jobs;
  for (;;) {
    const auto left = limit == 0 ? kPageSize : limit - static_cast<std::uint32_t>(jobs.size());
    request.set_page_size(std::min(kPageSize, left));
    auto page = (*session)->list(request);
    if (!page) return page.error();
    jobs.insert(jobs.end(), page->jobs().begin(), page->jobs().end());
    request.set_page_token(page->next_page_token());
    if (page->next_page_token().empty()) return jobs;
    if (limit > 0 && jobs.size() >= limit) {
      context.say("there are more; --limit 0 lists all");
      return jobs;
    }
  }
}

Outcome list_jobs(Context& context, const ListOptions& options) {
  auto request = request_of(options);
  if (!request) return request.error();
  auto jobs = collect(context, *request, options.limit);
  if (!jobs) return jobs.error();
  const auto table = job_table(*jobs, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_ls(CommandLine& line) {
  auto options = std::make_shared<ListOptions>();
  CLI::App& verb = line.verb("ls", "List jobs", "granary ls --state complete --tag study=walls");
  verb.add_option("--kind", options->kind, "discharge or chute")
      ->check(CLI::IsMember({"discharge", "chute"}))
      ->type_name("KIND");
  verb.add_option("--state", options->state,
                  "waiting, running, complete, error, unstable or cancelled")
      ->check(CLI::IsMember({"waiting", "running", "complete", "error", "unstable", "cancelled"}))
      ->type_name("STATE");
  verb.add_option("--tag", options->tags, "only jobs with this label: name=value (repeatable)")
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  verb.add_option("--limit", options->limit, "at most this many (default 100; 0: all)");
  line.on(verb, [options](Context& context) { return list_jobs(context, *options); });
}

}  // namespace granary::commands
