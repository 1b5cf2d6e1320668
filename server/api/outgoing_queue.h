// The write side of a gRPC stream reactor. gRPC allows one write at a time and reads the message
// until OnWriteDone, so the queue owns what is being written. Finish is called once, when nothing
// is in flight; after that the reactor is never touched again. Any thread may push.
#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include <grpcpp/grpcpp.h>

namespace granary::server {

template <typename Message>
class OutgoingQueue {
 public:
  struct Reactor {
    std::function<void(const Message*)> start_write;
    std::function<void(grpc::Status)> finish;
  };

  explicit OutgoingQueue(Reactor reactor) : reactor_(std::move(reactor)) {}

  // `replaces_last(last)` true: the newest unsent message is overwritten instead (progress).
  void push(Message message, const std::function<bool(const Message&)>& replaces_last = nullptr) {
    {
      std::lock_guard lock(mutex_);
      if (finish_) return;
      if (replaces_last && !queue_.empty() && replaces_last(queue_.back()))
        queue_.back() = std::move(message);
      else
        queue_.push_back(std::move(message));
    }
    pump();
  }

  void on_write_done(bool ok) {
    {
      std::lock_guard lock(mutex_);
      writing_ = false;
      if (!ok) {
        queue_.clear();
        finish_ = grpc::Status::OK;  // the peer is gone; nobody reads this
      }
    }
    pump();
  }

  // After what is queued has been written.
  void finish(grpc::Status status) {
    {
      std::lock_guard lock(mutex_);
      if (!finish_) finish_ = std::move(status);
    }
    pump();
  }

  // Without writing what is queued.
  void abort(grpc::Status status) {
    {
      std::lock_guard lock(mutex_);
      queue_.clear();
      if (!finish_) finish_ = std::move(status);
    }
    pump();
  }

 private:
  // The reactor's functions are called outside the lock: they may call back at once.
  void pump() {
    std::unique_lock lock(mutex_);
    if (writing_ || finished_) return;
    if (!queue_.empty()) {
      writing_ = true;
      current_ = std::move(queue_.front());
      queue_.pop_front();
      lock.unlock();
      reactor_.start_write(&current_);
    } else if (finish_) {
      finished_ = true;
      const grpc::Status status = *finish_;
      lock.unlock();
      reactor_.finish(status);
    }
  }

  Reactor reactor_;
  std::mutex mutex_;
  std::deque<Message> queue_;
  Message current_;
  bool writing_ = false;
  bool finished_ = false;
  std::optional<grpc::Status> finish_;
};

}  // namespace granary::server
