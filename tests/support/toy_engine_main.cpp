// The engine process of worker/run with the toy as its engine: what tests kill.
#include <cstdlib>

#include "tests/support/toy_simulation.h"
#include "worker/run/engine_process.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const pid_t parent = argc > 2 ? std::atoi(argv[2]) : 0;
  return granary::run::run_engine_process(argv[1], parent,
                                          {granary::testing::toy_factory(), "toy"});
}
