// The command tree, and what every verb is given when it runs. One file per verb adds itself with
// add_<verb>(line); catalogue.cpp lists them.
#pragma once

#include <CLI/CLI.hpp>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "client/render/table.h"
#include "client/session/session.h"
#include "client/session/settings.h"
#include "proto/contract/result.h"

namespace granary::commands {

// Options every verb understands, before or behind its name.
struct GlobalOptions {
  std::map<session::SettingKey, std::string> settings;
  std::string format = "table";
  std::string output;
  bool quiet = false;
  bool verbose = false;
};

// Data goes to stdout or to the file of -o; everything else to stderr.
class Context {
 public:
  explicit Context(const GlobalOptions& options) : options_(options) {}

  const GlobalOptions& options() const { return options_; }
  render::Format format() const { return *render::format_from(options_.format); }

  Result<session::Settings> settings() const;
  // Opened at the first call.
  Result<session::Session*> session();

  Status write(std::string_view data);
  Status write_rows(const render::Table& table, render::JsonShape shape);
  // For verbs whose -o names what they make: always on stdout; as table, one column alone.
  Status write_listing(const render::Table& table, std::size_t plain_column);

  void say(std::string_view text) const;     // unless -q
  void detail(std::string_view text) const;  // with -v
  void complain(const Error& error) const;   // always

 private:
  const GlobalOptions& options_;
  std::unique_ptr<session::Session> session_;
  std::ofstream file_;
};

using Outcome = Result<ExitCode>;
using Action = std::function<Outcome(Context&)>;

class CommandLine {
 public:
  CommandLine();

  // A verb below `parent` (default: the root). `example` is shown by --help.
  CLI::App& verb(const std::string& name, const std::string& help, const std::string& example,
                 CLI::App* parent = nullptr);
  // A verb that only groups others ("scene", "config").
  CLI::App& group(const std::string& name, const std::string& help, const std::string& example);
  void on(CLI::App& verb, Action action);

  const CLI::App& root() const { return root_; }

  // Parses and runs; the process's exit code.
  int run(int argc, const char* const* argv);

 private:
  void add_global_options();
  std::string describe_extra(int argc, const char* const* argv) const;
  int usage_error(const std::string& what) const;

  CLI::App root_;
  GlobalOptions options_;
  Action action_;
};

// "granary: what went wrong", always one line.
void print_error(const std::string& message);

}  // namespace granary::commands
