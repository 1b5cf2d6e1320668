#include "client/commands/catalogue.h"

namespace granary::commands {

void add_all_verbs(CommandLine& line) {
  add_run(line);
  add_up(line);
  add_check(line);
  add_scene(line);
  add_submit(line);
  add_watch(line);
  add_status(line);
  add_ls(line);
  add_cancel(line);
  add_retry(line);
  add_delete(line);
  add_logs(line);
  add_workers(line);
  add_values(line);
  add_explain(line);
  add_fetch(line);
  add_export(line);
  add_verify(line);
  add_query(line);
  add_sweep(line);
  add_optimize(line);
  add_price(line);
  add_ablate(line);
  add_study(line);
  add_backup(line);
  add_health(line);
  add_config(line);
  add_completion(line);
}

}  // namespace granary::commands
