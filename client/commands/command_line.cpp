#include "client/commands/command_line.h"

#include <algorithm>
#include <iostream>
#include <vector>

#include "proto/contract/field_path.h"
#include "proto/contract/version.h"

namespace granary::commands {
namespace {

constexpr const char* kCommonOptions =
    "Common options: --server ADDR, --format table|json|csv, -o FILE, -q, -v (granary --help)";

// Names a mistyped word could have meant: verbs and options of the parsed chain of verbs.
void collect_names(const CLI::App& app, std::vector<std::string>& names) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(sub->get_name());
    if (sub->parsed()) collect_names(*sub, names);
  }
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
}

const CLI::App& deepest_parsed(const CLI::App& app) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    if (sub->parsed()) return deepest_parsed(*sub);
  return app;
}

}  // namespace

void print_error(const std::string& message) {
  std::string line = render::printable(message);
  line.erase(line.find_last_not_of(' ') + 1);
  std::cerr << "granary: " << line << "\n" << std::flush;
}

Result<session::Settings> Context::settings() const {
  return session::resolve_settings(options_.settings, session::process_environment);
}

Result<session::Session*> Context::session() {
  if (session_) return session_.get();
  auto resolved = settings();
  if (!resolved) return resolved.error();
  auto opened =
      session::Session::open(*resolved, [this](session::NoticeLevel level, std::string_view text) {
        level == session::NoticeLevel::normal ? say(text) : detail(text);
      });
  if (!opened) return opened.error();
  session_ = std::move(*opened);
  detail("server " + session_->address());
  return session_.get();
}

Status Context::write(std::string_view data) {
  const bool to_file = !options_.output.empty() && options_.output != "-";
  if (to_file && !file_.is_open()) file_.open(options_.output, std::ios::binary);
  std::ostream& out = to_file ? static_cast<std::ostream&>(file_) : std::cout;
  out << data << std::flush;
  if (out) return Done{};
  return Error{ErrorCode::failed_precondition,
               (to_file ? options_.output : std::string("standard output")) + " cannot be written",
               ""};
}

Status Context::write_rows(const render::Table& table, render::JsonShape shape) {
  return write(render::render_rows(table, format(), shape));
}

Status Context::write_listing(const render::Table& table, std::size_t plain_column) {
  std::string text;
  if (format() == render::Format::table)
    for (const auto& row : table.rows) text += row[plain_column].get<std::string>() + "\n";
  else
    text = render::render_rows(table, format(), render::JsonShape::lines);
  std::cout << text << std::flush;
  if (std::cout) return Done{};
  return Error{ErrorCode::failed_precondition, "standard output cannot be written", ""};
}

void Context::say(std::string_view text) const {
  if (!options_.quiet) print_error(std::string(text));
}

void Context::detail(std::string_view text) const {
  if (options_.verbose && !options_.quiet) print_error(std::string(text));
}

void Context::complain(const Error& error) const {
  print_error(error.message);
}

CommandLine::CommandLine() : root_("Granary: granular-flow simulations as a service.", "granary") {
  root_.require_subcommand(0, 1);
  root_.fallthrough();
  root_.set_help_flag("-h,--help", "this text");
  root_.set_version_flag(
      "--version", std::string("granary ") + kProductVersion + " (engine " + kEngineVersion + ")",
      "program and engine version");
  root_.footer(
      "Example:\n  granary run tests/scenes/discharge_small.txtpb --format json\n"
      "A verb tells its own: granary run --help");
  root_.get_formatter()->column_width(34);
  add_global_options();
}

void CommandLine::add_global_options() {
  for (const session::SettingName& name : session::kSettingNames)
    root_.add_option_function<std::string>(
        name.option,
        [this, key = name.key](const std::string& value) { options_.settings[key] = value; },
        std::string(name.help) + " [" + name.environment + "]");
  root_.add_option("--format", options_.format, "table, json or csv")
      ->check(CLI::IsMember({"table", "json", "csv"}))
      ->type_name("FORMAT");
  root_.add_option("-o,--output", options_.output, "write data to this file, not to stdout");
  root_.add_flag("-q,--quiet", options_.quiet, "nothing on stderr but errors");
  root_.add_flag("-v,--verbose", options_.verbose, "say more on stderr");
}

CLI::App& CommandLine::verb(const std::string& name, const std::string& help,
                            const std::string& example, CLI::App* parent) {
  CLI::App& app = *(parent ? parent : &root_)->add_subcommand(name, help);
  app.fallthrough();
  app.footer("Example:\n  " + example + "\n" + kCommonOptions);
  return app;
}

CLI::App& CommandLine::group(const std::string& name, const std::string& help,
                             const std::string& example) {
  CLI::App& app = verb(name, help, example);
  app.require_subcommand(1);
  return app;
}

void CommandLine::on(CLI::App& verb, Action action) {
  verb.final_callback([this, action = std::move(action)] { action_ = action; });
}

// CLI11 lists what it could not place in reverse; people look for the first one.
std::string CommandLine::describe_extra(int argc, const char* const* argv) const {
  const std::vector<std::string> extras = root_.remaining(true);
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (std::find(extras.begin(), extras.end(), word) == extras.end()) continue;
    std::vector<std::string> names;
    collect_names(root_, names);
    const std::string nearest = nearest_name(word.substr(0, word.find('=')), names);
    const bool is_verb = word[0] != '-' && root_.get_subcommands().empty();
    const char* what = word[0] == '-' ? "unknown option" : is_verb ? "unknown verb" : "unexpected";
    return what + (" '" + word + "'") +
           (nearest.empty() ? "" : ", did you mean '" + nearest + "'?");
  }
  return "unexpected arguments";
}

int CommandLine::usage_error(const std::string& what) const {
  const CLI::App& app = deepest_parsed(root_);
  const std::string verb = &app == &root_ ? "" : " " + app.get_name();
  print_error(what + " (granary" + verb + " --help)");
  return static_cast<int>(ExitCode::usage);
}

int CommandLine::run(int argc, const char* const* argv) {
  try {
    root_.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    return usage_error(describe_extra(argc, argv));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return root_.exit(error);  // --help, --version
    return usage_error(error.what());
  }
  if (!action_) return usage_error("a verb is needed");
  Context context(options_);
  try {
    const Outcome outcome = action_(context);
    if (outcome) return static_cast<int>(*outcome);
    context.complain(outcome.error());
    return static_cast<int>(exit_code_of(outcome.error().code));
  } catch (const std::exception& error) {
    print_error(std::string("internal error: ") + error.what());
    return static_cast<int>(ExitCode::job_failed);
  }
}

}  // namespace granary::commands
