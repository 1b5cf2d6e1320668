#include "client/session/interrupt.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <stdexcept>

#include "proto/contract/result.h"

namespace granary::session {
namespace {

std::atomic<int> wake_fd{-1};  // -1: no Interrupt lives, or its one warning is used up

void on_signal(int) {
  const int fd = wake_fd.exchange(-1);
  const char byte = 'i';
  if (fd < 0 || write(fd, &byte, 1) != 1) _exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void install_default_interrupt() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
}

Interrupt::Interrupt() {
  if (pipe2(pipe_, O_CLOEXEC) != 0) throw std::runtime_error("cannot create a pipe");
  listener_ = std::thread([this] { listen(); });
  wake_fd = pipe_[1];
  install_default_interrupt();
}

Interrupt::~Interrupt() {
  wake_fd = -1;
  close(pipe_[1]);  // end of file wakes the listener
  listener_.join();
  close(pipe_[0]);
}

void Interrupt::listen() {
  char byte = 0;
  if (read(pipe_[0], &byte, 1) != 1) return;
  const std::lock_guard lock(mutex_);
  requested_ = true;
  if (action_) action_();
  arrived_.notify_all();
}

bool Interrupt::requested() const {
  const std::lock_guard lock(mutex_);
  return requested_;
}

bool Interrupt::wait_for_s(double duration_s) {
  std::unique_lock lock(mutex_);
  return arrived_.wait_for(lock, std::chrono::duration<double>(duration_s),
                           [this] { return requested_; });
}

Interrupt::Action::Action(Interrupt& interrupt, std::function<void()> action)
    : interrupt_(interrupt) {
  const std::lock_guard lock(interrupt_.mutex_);
  if (interrupt_.requested_) action();
  interrupt_.action_ = std::move(action);
}

Interrupt::Action::~Action() {
  const std::lock_guard lock(interrupt_.mutex_);
  interrupt_.action_ = nullptr;
}

}  // namespace granary::session
