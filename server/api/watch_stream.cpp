#include "server/api/watch_stream.h"

#include "server/api/outgoing_queue.h"

namespace granary::server {
namespace {

using Queue = OutgoingQueue<v1::JobEvent>;

// Bounded for slow readers: unsent progress is replaced, state changes are few.
class QueueWatcher : public Watcher {
 public:
  explicit QueueWatcher(Queue::Reactor reactor) : queue(std::move(reactor)) {}

  void deliver(const v1::JobEvent& event) override {
    if (!event.has_progress()) return queue.push(event);
    queue.push(event, [](const v1::JobEvent& last) { return last.has_progress(); });
  }
  void finish() override { queue.finish(grpc::Status::OK); }

  Queue queue;
};

class WatchReactor : public grpc::ServerWriteReactor<v1::JobEvent> {
 public:
  WatchReactor(Backend& backend, const v1::WatchJobRequest& request)
      : backend_(backend),
        watcher_(std::make_shared<QueueWatcher>(
            Queue::Reactor{[this](const v1::JobEvent* event) { StartWrite(event); },
                           [this](grpc::Status status) { Finish(std::move(status)); }})) {
    const auto id = job_id_from(request.name());
    if (!id) {
      watcher_->queue.finish({grpc::StatusCode::NOT_FOUND,
                              "no job '" + request.name() + "', names look like jobs/17"});
      return;
    }
    job_ = *id;
    auto outcome = std::make_shared<Status>(Done{});
    auto work = [&backend, job = job_, after = request.after_sequence(), watcher = watcher_,
                 outcome] { *outcome = backend.dispatcher.watch(job, after, watcher); };
    auto reply = [watcher = watcher_, outcome](const Status& committed) {
      const Status& status = committed.ok() ? *outcome : committed;
      if (!status.ok()) watcher->queue.finish(to_grpc(status));
    };
    backend.owner.post(std::move(work), std::move(reply));
  }

  void OnWriteDone(bool ok) override { watcher_->queue.on_write_done(ok); }
  void OnCancel() override { watcher_->queue.abort(grpc::Status::CANCELLED); }
  void OnDone() override {
    backend_.touch();
    backend_.owner.post([&backend = backend_, job = job_,
                         watcher = watcher_] { backend.dispatcher.unwatch(job, watcher.get()); },
                        nullptr);
    delete this;
  }

 private:
  Backend& backend_;
  std::shared_ptr<QueueWatcher> watcher_;
  JobId job_ = 0;
};

}  // namespace

grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Backend& backend,
                                                  const v1::WatchJobRequest& request) {
  backend.touch();
  return new WatchReactor(backend, request);
}

}  // namespace granary::server
