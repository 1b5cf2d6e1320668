#include "worker/run/stop_signals.h"

#include <signal.h>

namespace granary::run {
namespace {

StopSignal the_signal{StopRequest::none};
StopRequest interrupt_request = StopRequest::cancel;
StopRequest terminate_request = StopRequest::release;

void on_signal(int number) {
  the_signal.store(number == SIGINT ? interrupt_request : terminate_request);
  signal(number, SIG_DFL);
}

void handle(int number) {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigaction(number, &action, nullptr);
}

}  // namespace

StopSignal& stop_signal() {
  return the_signal;
}

void listen_to_stop_signals(StopRequest on_interrupt, StopRequest on_terminate) {
  interrupt_request = on_interrupt;
  terminate_request = on_terminate;
  handle(SIGINT);
  handle(SIGTERM);
  signal(SIGPIPE, SIG_IGN);
}

}  // namespace granary::run
