// Every verb, in the order of --help. One file each.
#pragma once

#include "client/commands/command_line.h"

namespace granary::commands {

void add_run(CommandLine& line);
void add_up(CommandLine& line);
void add_check(CommandLine& line);
void add_scene(CommandLine& line);
void add_submit(CommandLine& line);
void add_watch(CommandLine& line);
void add_status(CommandLine& line);
void add_ls(CommandLine& line);
void add_cancel(CommandLine& line);
void add_retry(CommandLine& line);
void add_delete(CommandLine& line);
void add_logs(CommandLine& line);
void add_workers(CommandLine& line);
void add_values(CommandLine& line);
void add_explain(CommandLine& line);
void add_fetch(CommandLine& line);
void add_export(CommandLine& line);
void add_verify(CommandLine& line);
void add_query(CommandLine& line);
void add_sweep(CommandLine& line);
void add_optimize(CommandLine& line);
void add_price(CommandLine& line);
void add_ablate(CommandLine& line);
void add_study(CommandLine& line);
void add_backup(CommandLine& line);
void add_health(CommandLine& line);
void add_config(CommandLine& line);
void add_completion(CommandLine& line);

void add_all_verbs(CommandLine& line);

}  // namespace granary::commands
