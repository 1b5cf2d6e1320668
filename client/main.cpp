// granary: the command-line client. Wiring only; verbs live in client/commands.
#include "client/commands/catalogue.h"
#include "client/session/interrupt.h"

int main(int argc, char** argv) {
  granary::session::install_default_interrupt();
  granary::commands::CommandLine line;
  granary::commands::add_all_verbs(line);
  return line.run(argc, argv);
}
