#include "server/api/study_watch_stream.h"

#include <memory>

#include "server/api/outgoing_queue.h"

namespace granary::server {
namespace {

using Queue = OutgoingQueue<v1::Study>;

// Bounded for slow readers: what has not been sent is replaced.
class QueueWatcher : public StudyWatcher {
 public:
  explicit QueueWatcher(Queue::Reactor reactor) : queue(std::move(reactor)) {}

  void deliver(const v1::Study& study) override {
    queue.push(study, [](const v1::Study&) { return true; });
  }
  void finish() override { queue.finish(grpc::Status::OK); }

  Queue queue;
};

class StudyWatchReactor : public grpc::ServerWriteReactor<v1::Study> {
 public:
  StudyWatchReactor(Backend& backend, StudyId study)
      : backend_(backend),
        study_(study),
        watcher_(std::make_shared<QueueWatcher>(
            Queue::Reactor{[this](const v1::Study* message) { StartWrite(message); },
                           [this](grpc::Status status) { Finish(std::move(status)); }})) {
    auto outcome = std::make_shared<Status>(Done{});
    auto work = [&backend, study, watcher = watcher_, outcome] {
      *outcome = backend.studies.watch(study, watcher);
    };
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
    backend_.owner.post([&backend = backend_, study = study_,
                         watcher = watcher_] { backend.studies.unwatch(study, watcher.get()); },
                        nullptr);
    delete this;
  }

 private:
  Backend& backend_;
  StudyId study_;
  std::shared_ptr<QueueWatcher> watcher_;
};

}  // namespace

grpc::ServerWriteReactor<v1::Study>* watch_study(Backend& backend,
                                                 const v1::WatchStudyRequest& request) {
  backend.touch();
  // Number 0 is no study: the ordinary "not found" answers.
  return new StudyWatchReactor(backend, study_id_from(request.name()).value_or(0));
}

}  // namespace granary::server
