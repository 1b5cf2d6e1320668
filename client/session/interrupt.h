// Ctrl-C as an event. While an Interrupt lives, the first SIGINT runs the registered action on a
// thread of its own and ends waits; a second one ends the process with 130. Without one, SIGINT
// ends the process with 130 (install_default_interrupt). At most one Interrupt at a time.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace granary::session {

void install_default_interrupt();

class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool requested() const;
  // Sleeps; true as soon as an interrupt is there.
  bool wait_for_s(double duration_s);

  // Runs `action` at the interrupt (at once if it has been) until the Action goes out of scope; the
  // destructor waits for a running action, so what it captures may die afterwards.
  class Action {
   public:
    Action(Interrupt& interrupt, std::function<void()> action);
    ~Action();
    Action(const Action&) = delete;
    Action& operator=(const Action&) = delete;

   private:
    Interrupt& interrupt_;
  };

 private:
  void listen();

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  bool requested_ = false;
  std::function<void()> action_;
  int pipe_[2] = {-1, -1};
  std::thread listener_;
};

}  // namespace granary::session
