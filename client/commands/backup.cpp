// granary backup: a consistent copy of the server's database while it goes on.
#include "client/session/backup.h"

#include "client/commands/catalogue.h"
#include "client/render/byte_progress.h"
#include "client/render/progress_display.h"

namespace granary::commands {
namespace {

Outcome backup(Context& context, const std::string& file, bool force) {
  auto session = context.session();
  if (!session) return session.error();
  render::ByteProgress bytes(!context.options().quiet && render::terminal_of_stderr().is_terminal);
  const auto made = session::fetch_backup(
      **session, file, force,
      [&](std::uint64_t have_bytes, std::uint64_t size_bytes) { bytes.show(have_bytes, size_bytes); });
  bytes.close();
  if (!made) return made.error();
  const render::Table table{{"file", "size_bytes", "sha256"}, {{file, made->size_bytes, made->sha256}}};
  if (auto written = context.write_listing(table, 0); !written) return written.error();
  return ExitCode::ok;
}

}  // namespace

void add_backup(CommandLine& line) {
  auto file = std::make_shared<std::string>();
  auto force = std::make_shared<bool>(false);
  CLI::App& verb = line.verb("backup", "Copy the server's database into FILE while it goes on (results are files below artifacts/)",
                             "granary backup granary-$(date +%F).db");
  verb.add_option("FILE", *file, "where to write; becomes granary.db of a data directory to restore")
      ->required()
      ->type_name("");
  verb.add_flag("--force", *force, "replace a file that exists");
  line.on(verb, [file, force](Context& context) { return backup(context, *file, *force); });
}

}  // namespace granary::commands
