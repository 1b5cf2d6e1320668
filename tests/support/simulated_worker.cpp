#include "tests/support/simulated_worker.h"

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "granary/v1/worker.grpc.pb.h"
#include "proto/contract/sha256.h"
#include "proto/contract/version.h"

namespace granary::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kResultFile = "a result of nothing";

}  // namespace

struct SimulatedWorker::Stream {
  Stream(const std::string& address, const std::string& id, unsigned slots, bool finishes)
      : finish(finishes), stub(v1::Workers::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()))) {
    artifact.set_sha256(sha256_hex(kResultFile));
    artifact.set_size_bytes(std::string_view(kResultFile).size());
    calls = stub->Synchronize(&context);
    v1::WorkerMessage hello;
    hello.mutable_hello()->set_worker_id(id);
    hello.mutable_hello()->set_host("simulated");
    hello.mutable_hello()->set_slots(slots);
    hello.mutable_hello()->set_engine_version(kEngineVersion);
    for (const char* kind : {"discharge", "chute"}) hello.mutable_hello()->add_kinds(kind);
    calls->Write(hello);
    reader = std::thread([this] { read(); });
  }

  void read() {
    v1::ServerMessage message;
    while (calls->Read(&message))
      if (message.has_assign()) take(message.assign());
    (void)calls->Finish();
  }

  void take(const v1::TaskAssignment& task) {
    {
      std::lock_guard lock(mutex);
      if (told != Clock::time_point{})
        lease_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - told).count());
      jobs.push_back(task.job());
    }
    if (!finish) return;
    if (!uploaded) upload(task);
    v1::WorkerMessage message;
    auto& finished = *message.mutable_finished();
    finished.set_task(task.task());
    finished.set_fencing_token(task.fencing_token());
    finished.set_outcome(v1::TaskFinished::COMPLETE);
    *finished.mutable_artifact() = artifact;
    finished.mutable_result()->set_kind("discharge");
    (*finished.mutable_result()->mutable_values())["f1_m"].set_value(1);
    {
      std::lock_guard lock(mutex);
      told = Clock::now();
    }
    ++done;
    calls->Write(message);
  }

  // The server keeps one file for all: the content is its name.
  void upload(const v1::TaskAssignment& task) {
    grpc::ClientContext upload_context;
    v1::UploadResponse response;
    auto writer = stub->Upload(&upload_context, &response);
    v1::UploadChunk chunk;
    chunk.mutable_header()->set_task(task.task());
    chunk.mutable_header()->set_fencing_token(task.fencing_token());
    *chunk.mutable_header()->mutable_artifact() = artifact;
    chunk.set_data(kResultFile);
    writer->Write(chunk);
    writer->WritesDone();
    uploaded = writer->Finish().ok();
  }

  bool finish;
  std::unique_ptr<v1::Workers::Stub> stub;
  v1::Artifact artifact;
  grpc::ClientContext context;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::ServerMessage>> calls;
  std::mutex mutex;
  std::vector<double> lease_ms;
  std::vector<std::string> jobs;
  Clock::time_point told;
  std::atomic<std::uint64_t> done = 0;
  bool uploaded = false;
  std::thread reader;
};

SimulatedWorker::SimulatedWorker(const std::string& address, const std::string& id, unsigned slots, bool finish)
    : stream_(std::make_unique<Stream>(address, id, slots, finish)) {}

SimulatedWorker::~SimulatedWorker() { stop(); }

void SimulatedWorker::stop() {
  stream_->context.TryCancel();
  if (stream_->reader.joinable()) stream_->reader.join();
}

std::uint64_t SimulatedWorker::tasks_done() const { return stream_->done; }
std::vector<double> SimulatedWorker::lease_ms() const { return stream_->lease_ms; }
std::vector<std::string> SimulatedWorker::jobs() const { return stream_->jobs; }

}  // namespace granary::test
