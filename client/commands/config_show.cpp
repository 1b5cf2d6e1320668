// granary config show: every setting, and where it came from.
#include "client/commands/catalogue.h"

namespace granary::commands {
namespace {

Outcome show_config(Context& context) {
  auto settings = context.settings();
  if (!settings) return settings.error();
  render::Table table{{"key", "value", "source"}, {}};
  for (const session::SettingName& name : session::kSettingNames) {
    const session::Setting& setting = (*settings)[name.key];
    table.rows.push_back(
        {name.config, setting.value.empty() ? render::Json(nullptr) : render::Json(setting.value),
         setting.source});
  }
  if (auto written = context.write_rows(table, render::JsonShape::array); !written)
    return written.error();
  context.detail("config file: " +
                 session::config_file_path(session::process_environment).string());
  return ExitCode::ok;
}

}  // namespace

void add_config(CommandLine& line) {
  CLI::App& group = line.group("config", "Settings of this client", "granary config show");
  line.on(line.verb("show", "Every setting and where it came from", "granary config show", &group),
          show_config);
}

}  // namespace granary::commands
