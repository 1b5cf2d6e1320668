// The engine process of worker/run with the toy as its engine: what tests kill.
#include "tests/support/toy_simulation.h"
#include "worker/run/engine_process.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  return granary::run::run_engine_process(argv[1], {granary::testing::toy_factory(), "toy"});
}
