// granary export: a job's result in other forms. The layout of result files is the worker's
// business, so the worker program beside this one converts; this verb fetches and cleans up.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "client/commands/catalogue.h"
#include "client/commands/jobs.h"
#include "client/session/child_process.h"
#include "client/session/fetch.h"

namespace granary::commands {
namespace {

namespace fs = std::filesystem;

// Removed with whatever it holds.
class WorkDirectory {
 public:
  static Result<std::unique_ptr<WorkDirectory>> make() {
    std::string path = (fs::temp_directory_path() / "granary-export-XXXXXX").string();
    if (mkdtemp(path.data()) == nullptr)
      return Error{ErrorCode::failed_precondition, path + " cannot be made", ""};
    return std::make_unique<WorkDirectory>(path);
  }
  explicit WorkDirectory(fs::path path) : path_(std::move(path)) {}
  ~WorkDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkDirectory(const WorkDirectory&) = delete;
  WorkDirectory& operator=(const WorkDirectory&) = delete;
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// Names of the files written below `directory`.
Result<std::vector<std::string>> convert(const WorkDirectory& work, const fs::path& result,
                                         const std::string& form, const std::string& directory) {
  const fs::path log = work / "log";
  auto code = session::run_child({.command = {session::program_directory() / "granary-worker",
                                              "--export", result, "--to", form, "-o", directory},
                                  .log_file = log});
  if (!code) return code.error();
  std::vector<std::string> lines = lines_of(log);
  if (*code == 0) return lines;
  const bool is_damaged = *code == static_cast<int>(ExitCode::verification_failed);
  return Error{is_damaged ? ErrorCode::data_loss : ErrorCode::failed_precondition,
               lines.empty() ? "the export failed" : lines.back(), ""};
}

Outcome export_job(Context& context, const std::string& text, const std::string& form) {
  auto job = job_name(text);
  if (!job) return job.error();
  std::string directory = context.options().output;
  if (directory.empty()) {
    directory = *job;
    std::replace(directory.begin(), directory.end(), '/', '-');
  }
  auto session = context.session();
  if (!session) return session.error();
  auto work = WorkDirectory::make();
  if (!work) return work.error();
  const session::FetchRequest request{
      .job = *job, .file = **work / "result.h5", .record_checksum = false};
  session::Interrupt interrupt;
  auto fetched = session::fetch_result(
      **session, request, [](std::uint64_t, std::uint64_t) {}, interrupt);
  if (interrupt.requested()) return ExitCode::interrupted;
  if (!fetched) return fetched.error();
  auto files = convert(**work, request.file, form, directory);
  if (!files) return files.error();
  render::Table table{{"job", "file"}, {}};
  for (const std::string& file : *files) table.rows.push_back({*job, file});
  if (auto written = context.write_listing(table, 1); !written) return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_export(CommandLine& line) {
  auto name = std::make_shared<std::string>();
  auto form = std::make_shared<std::string>();
  CLI::App& verb = line.verb("export", "Write a job's result in another form",
                             "granary export jobs/12 --to csv -o tables");
  verb.add_option("JOB", *name, "job name")->required()->type_name("");
  verb.add_option(
          "--to", *form,
          "csv: tables; svg: one picture; xyz: frames for OVITO; paraview: frames (.pvd, .vtp)")
      ->required()
      ->check(CLI::IsMember({"csv", "svg", "xyz", "paraview"}))
      ->type_name("FORM");
  line.on(verb, [name, form](Context& context) { return export_job(context, *name, *form); });
}

}  // namespace granary::commands
