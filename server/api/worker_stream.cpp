#include "server/api/worker_stream.h"

#include <memory>

#include "proto/contract/version.h"
#include "server/api/outgoing_queue.h"

namespace granary::server {
namespace {

using Queue = OutgoingQueue<v1::ServerMessage>;

class StreamLink : public WorkerLink {
 public:
  explicit StreamLink(Queue::Reactor reactor) : queue(std::move(reactor)) {}
  void send(v1::ServerMessage message) override { queue.push(std::move(message)); }
  void close() override { queue.abort({grpc::StatusCode::ABORTED, "replaced by a newer stream"}); }

  Queue queue;
};

class WorkerReactor : public grpc::ServerBidiReactor<v1::WorkerMessage, v1::ServerMessage> {
 public:
  explicit WorkerReactor(Backend& backend)
      : backend_(backend),
        link_(std::make_shared<StreamLink>(
            Queue::Reactor{[this](const v1::ServerMessage* message) { StartWrite(message); },
                           [this](grpc::Status status) { Finish(std::move(status)); }})) {
    StartRead(&incoming_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return link_->queue.abort(grpc::Status::OK);
    if (!accept()) return;
    incoming_.Clear();
    StartRead(&incoming_);
  }
  void OnWriteDone(bool ok) override { link_->queue.on_write_done(ok); }
  void OnCancel() override { link_->queue.abort(grpc::Status::CANCELLED); }
  void OnDone() override {
    if (!worker_id_.empty())
      post([link = link_, worker = worker_id_](Dispatcher& d, Now now) {
        d.worker_disconnected(worker, link.get(), now);
      });
    delete this;
  }

 private:
  // False: the stream is being finished.
  bool accept() {
    if (incoming_.has_hello()) return accept_hello();
    if (worker_id_.empty()) {
      link_->queue.abort(
          {grpc::StatusCode::FAILED_PRECONDITION, "the first message must be hello"});
      return false;
    }
    if (incoming_.has_finished()) check_delivery(*incoming_.mutable_finished());
    post([worker = worker_id_, message = std::move(incoming_)](Dispatcher& d, Now now) {
      switch (message.what_case()) {
        case v1::WorkerMessage::kHeartbeat: return d.heartbeat(worker, message.heartbeat(), now);
        case v1::WorkerMessage::kProgress: return d.task_progress(worker, message.progress(), now);
        case v1::WorkerMessage::kFinished: return d.task_finished(worker, message.finished(), now);
        case v1::WorkerMessage::kCheckpointed:
          return d.task_checkpointed(worker, message.checkpointed(), now);
        case v1::WorkerMessage::kFillingStored:
          return d.filling_stored(worker, message.filling_stored(), now);
        default: return;
      }
    });
    return true;
  }

  // A job is complete when its file is here, not when somebody says so.
  void check_delivery(v1::TaskFinished& finished) const {
    if (finished.outcome() != v1::TaskFinished::COMPLETE) return;
    const auto bytes = backend_.artifacts.size_of(finished.artifact().sha256());
    if (bytes.ok() && *bytes == finished.artifact().size_bytes()) return;
    finished.set_outcome(v1::TaskFinished::CRASHED);
    finished.set_message("the worker reported a result file that never arrived");
    finished.clear_artifact();
    finished.clear_result();
  }

  bool accept_hello() {
    const v1::WorkerHello& hello = incoming_.hello();
    std::string refusal;
    if (hello.worker_id().empty() || hello.slots() == 0)
      refusal = "hello needs worker_id and slots > 0";
    else if (hello.engine_version() != kEngineVersion)
      refusal = "this worker's engine is " + hello.engine_version() + ", the server keys jobs on " +
                kEngineVersion;
    if (!refusal.empty()) {
      link_->queue.abort({grpc::StatusCode::FAILED_PRECONDITION, refusal});
      return false;
    }
    worker_id_ = hello.worker_id();
    post([link = link_, hello](Dispatcher& d, Now now) { d.worker_connected(hello, link, now); });
    return true;
  }

  void post(std::function<void(Dispatcher&, Now)> work) {
    backend_.owner.post(
        [&backend = backend_, work = std::move(work)] { work(backend.dispatcher, system_now()); },
        nullptr);
  }

  Backend& backend_;
  std::shared_ptr<StreamLink> link_;
  v1::WorkerMessage incoming_;
  std::string worker_id_;
};

}  // namespace

grpc::ServerBidiReactor<v1::WorkerMessage, v1::ServerMessage>* serve_worker(Backend& backend) {
  return new WorkerReactor(backend);
}

}  // namespace granary::server
