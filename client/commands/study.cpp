// granary study: ls, history, pause, resume, extend, cancel.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "client/commands/catalogue.h"
#include "client/commands/studies.h"
#include "client/session/child_process.h"

namespace granary::commands {
namespace {

using Change = std::function<Result<v1::Study>(session::Session&, const std::string& name)>;

Outcome list(Context& context, const std::string& kind, std::uint32_t limit) {
  auto session = context.session();
  if (!session) return session.error();
  std::vector<v1::Study> studies;
  v1::ListStudiesRequest request;
  request.set_kind(kind);
  for (;;) {
    const auto left = limit == 0 ? 500 : limit - static_cast<std::uint32_t>(studies.size());
    request.set_page_size(std::min<std::uint32_t>(500, left));
    auto page = (*session)->list_studies(request);
    if (!page) return page.error();
    studies.insert(studies.end(), page->studies().begin(), page->studies().end());
    request.set_page_token(page->next_page_token());
    if (page->next_page_token().empty() || (limit > 0 && studies.size() >= limit)) break;
  }
  const auto table = study_table(studies, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

// The layout of HDF5 files is the worker's business: the worker program beside this one writes it.
Status write_hdf5(const v1::StudyHistory& history, const std::string& file) {
  char folder[] = "/tmp/granary-history-XXXXXX";
  if (mkdtemp(folder) == nullptr)
    return Error{ErrorCode::failed_precondition, "no temporary directory can be made", ""};
  const std::filesystem::path work(folder), input = work / "history.pb", log = work / "log";
  std::ofstream out(input, std::ios::binary);
  out << history.SerializeAsString();
  out.close();
  auto code = session::run_child({.command = {session::program_directory() / "granary-worker",
                                              "--export-history", input, "-o", file},
                                  .log_file = log});
  std::ifstream in(log);
  std::string why, line;
  while (std::getline(in, line)) why = line;
  std::error_code ignored;
  std::filesystem::remove_all(work, ignored);
  if (!code) return code.error();
  if (*code == 0) return Done{};
  return Error{ErrorCode::failed_precondition, why.empty() ? "the export failed" : why, ""};
}

Status export_history(session::Session& session, const std::string& name,
                      std::vector<v1::Trial> trials, const std::string& file) {
  auto study = session.get_study(name);
  if (!study) return study.error();
  v1::StudyHistory history;
  *history.mutable_study() = std::move(*study);
  for (v1::Trial& trial : trials) *history.add_trials() = std::move(trial);
  return write_hdf5(history, file);
}

Outcome history(Context& context, const std::string& text, const std::string& hdf5_file) {
  auto name = study_name(text);
  if (!name) return name.error();
  auto session = context.session();
  if (!session) return session.error();
  auto trials = (*session)->trials(*name);
  if (!trials) return trials.error();
  if (!hdf5_file.empty()) {
    if (auto exported = export_history(**session, *name, std::move(*trials), hdf5_file); !exported)
      return exported.error();
    return ExitCode::ok;
  }
  const auto table = trial_table(*trials, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  return ExitCode::ok;
}

Outcome change(Context& context, const std::string& text, const Change& act) {
  auto name = study_name(text);
  if (!name) return name.error();
  auto session = context.session();
  if (!session) return session.error();
  auto study = act(**session, *name);
  if (!study) return study.error();
  const auto table = study_table({*study}, context.format());
  if (auto written = context.write_rows(table, render::JsonShape::lines); !written)
    return written.error();
  return ExitCode::ok;
}

void add_ls(CommandLine& line, CLI::App& group) {
  auto kind = std::make_shared<std::string>();
  auto limit = std::make_shared<std::uint32_t>(100);
  CLI::App& verb = line.verb("ls", "List studies, newest first", "granary study ls", &group);
  verb.add_option("--kind", *kind, "sweep, optimize, price or ablate")
      ->check(CLI::IsMember({"sweep", "optimize", "price", "ablate"}))
      ->type_name("KIND");
  verb.add_option("--limit", *limit, "at most this many (default 100; 0: all)");
  line.on(verb, [kind, limit](Context& context) { return list(context, *kind, *limit); });
}

CLI::App& verb_on_study(CommandLine& line, CLI::App& group, const std::string& name,
                        const std::string& help, const std::shared_ptr<std::string>& study) {
  CLI::App& verb = line.verb(name, help, "granary study " + name + " studies/3", &group);
  verb.add_option("STUDY", *study, "study name")->required()->type_name("");
  return verb;
}

void add_history(CommandLine& line, CLI::App& group) {
  auto study = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  CLI::App& verb = verb_on_study(line, group, "history", "Every trial of a study", study);
  verb.add_option("--hdf5", *file, "write everything to this HDF5 file instead")->type_name("FILE");
  line.on(verb, [study, file](Context& context) { return history(context, *study, *file); });
}

void add_pause_and_resume(CommandLine& line, CLI::App& group) {
  for (const bool pauses : {true, false}) {
    auto study = std::make_shared<std::string>();
    CLI::App& verb = verb_on_study(
        line, group, pauses ? "pause" : "resume",
        pauses ? "Propose nothing more; what is queued goes on" : "Go on with a paused study",
        study);
    line.on(verb, [study, pauses](Context& context) {
      return change(context, *study, [pauses](session::Session& session, const std::string& name) {
        return pauses ? session.pause_study(name) : session.resume_study(name);
      });
    });
  }
}

void add_extend(CommandLine& line, CLI::App& group) {
  auto study = std::make_shared<std::string>();
  auto budget = std::make_shared<std::uint32_t>(0);
  CLI::App& verb = line.verb("extend", "Give an optimization more trials",
                             "granary study extend studies/3 --budget 200", &group);
  verb.add_option("STUDY", *study, "study name")->required()->type_name("");
  verb.add_option("--budget", *budget, "the new total number of trials")->required();
  line.on(verb, [study, budget](Context& context) {
    return change(context, *study, [budget](session::Session& session, const std::string& name) {
      v1::ExtendStudyRequest request;
      request.set_name(name);
      request.set_budget(*budget);
      return session.extend_study(request);
    });
  });
}

void add_cancel(CommandLine& line, CLI::App& group) {
  auto study = std::make_shared<std::string>();
  auto keep_jobs = std::make_shared<bool>(false);
  CLI::App& verb = verb_on_study(line, group, "cancel", "End a study and its queued jobs", study);
  verb.add_flag("--keep-jobs", *keep_jobs, "let its waiting and running jobs end");
  line.on(verb, [study, keep_jobs](Context& context) {
    return change(context, *study, [keep_jobs](session::Session& session, const std::string& name) {
      v1::CancelStudyRequest request;
      request.set_name(name);
      request.set_keep_jobs(*keep_jobs);
      return session.cancel_study(request);
    });
  });
}

}  // namespace

void add_study(CommandLine& line) {
  CLI::App& group = line.group("study", "Sweeps, optimizations and other studies",
                               "granary study history studies/3 --format csv");
  add_ls(line, group);
  add_history(line, group);
  add_pause_and_resume(line, group);
  add_extend(line, group);
  add_cancel(line, group);
}

}  // namespace granary::commands
