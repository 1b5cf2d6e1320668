// One Watch call, of whatever is watched: a watcher on the owner thread's side, a write reactor on
// gRPC's side, a bounded queue between them.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "server/api/backend.h"
#include "server/api/outgoing_queue.h"

namespace granary::server {

template <class Message, class Watcher>
struct WatchSource {
  // Both on the owner thread; an error of watch() ends the call.
  std::function<Status(std::shared_ptr<Watcher>)> watch;
  std::function<void(const Watcher*)> unwatch;
  // Bounded for slow readers: may `next` take the place of `last`, which has not been sent?
  bool (*replaces)(const Message& last, const Message& next);
};

template <class Message, class Watcher>
class WatchReactor : public grpc::ServerWriteReactor<Message> {
 public:
  using Source = WatchSource<Message, Watcher>;

  WatchReactor(Backend& backend, Source source)
      : backend_(backend),
        unwatch_(std::move(source.unwatch)),
        queued_(std::make_shared<Queued>(
            typename Queue::Reactor{
                [this](const Message* message) { this->StartWrite(message); },
                [this](grpc::Status status) { this->Finish(std::move(status)); }},
            source.replaces)) {
    auto outcome = std::make_shared<Status>(Done{});
    auto work = [watch = std::move(source.watch), queued = queued_, outcome] {
      *outcome = watch(queued);
    };
    auto reply = [queued = queued_, outcome](const Status& committed) {
      const Status& status = committed.ok() ? *outcome : committed;
      if (!status.ok()) queued->queue.finish(to_grpc(status));
    };
    backend_.touch();
    backend_.owner.post(std::move(work), std::move(reply));
  }

  void OnWriteDone(bool ok) override { queued_->queue.on_write_done(ok); }
  void OnCancel() override { queued_->queue.abort(grpc::Status::CANCELLED); }
  void OnDone() override {
    backend_.touch();
    backend_.owner.post(
        [unwatch = std::move(unwatch_), queued = queued_] { unwatch(queued.get()); }, nullptr);
    delete this;
  }

 private:
  using Queue = OutgoingQueue<Message>;

  struct Queued : Watcher {
    Queued(typename Queue::Reactor reactor, bool (*replaces_)(const Message&, const Message&))
        : queue(std::move(reactor)), replaces(replaces_) {}
    void deliver(const Message& message) override {
      queue.push(message, [&](const Message& last) { return replaces(last, message); });
    }
    void finish() override { queue.finish(grpc::Status::OK); }

    Queue queue;
    bool (*replaces)(const Message& last, const Message& next);
  };

  Backend& backend_;
  std::function<void(const Watcher*)> unwatch_;
  std::shared_ptr<Queued> queued_;
};

}  // namespace granary::server
