// Any sequence of worker messages, connections, losses and time against the real dispatcher on a real
// database in memory. Whatever comes: each job ends at most once, a running job has one open task, and
// what the queue counts is what the database holds.
#include <cstdint>
#include <memory>
#include <string>

#include "server/jobs/dispatcher.h"
#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"
#include "tests/fuzz/require.h"

namespace {

using namespace granary;
using namespace granary::server;

class DeafLink : public WorkerLink {
 public:
  void send(v1::ServerMessage) override {}
  void close() override {}
};

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return size_ == 0; }
  std::uint8_t byte() { return size_ == 0 ? 0 : (--size_, *data_++); }
  std::string text(std::size_t bytes) {
    bytes = std::min(bytes, size_);
    std::string out(reinterpret_cast<const char*>(data_), bytes);
    data_ += bytes;
    size_ -= bytes;
    return out;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

class World {
 public:
  World() : store_(database_.connection()), dispatcher_(store_, {}) { dispatcher_.reload(now_); }

  void step(Bytes& input) {
    now_.steady_ms += input.byte() * 100;
    const std::string worker = input.byte() % 2 ? "a" : "b";
    const std::uint8_t what = input.byte() % 8;
    database_.begin();
    try {
      act(what, worker, input);
      database_.commit();
      for (const auto& effect : dispatcher_.take_effects()) effect();
    } catch (const std::exception&) {  // as the owner thread does with a failed commit
      database_.rollback();
      dispatcher_.reload(now_);
    }
  }

  void check() {
    auto& connection = database_.connection();
    const auto count = [&](const char* sql) { return connection.execAndGet(sql).getInt64(); };
    require(count("SELECT count(*) FROM job_event WHERE state IN (3,4,5) GROUP BY job HAVING count(*) > 1 UNION ALL SELECT 0") == 0,
            "a job ends once");
    require(count("SELECT count(*) FROM task WHERE ended_ms = 0") == count("SELECT count(*) FROM job WHERE state = 2"),
            "a running job has one open task");
    require(static_cast<std::int64_t>(dispatcher_.tally().waiting()) == count("SELECT count(*) FROM job WHERE state = 1"),
            "waiting jobs are counted right");
    require(static_cast<std::int64_t>(dispatcher_.tally().running()) == count("SELECT count(*) FROM job WHERE state = 2"),
            "running jobs are counted right");
  }

 private:
  void act(std::uint8_t what, const std::string& worker, Bytes& input) {
    switch (what) {
      case 0: return submit();
      case 1: return connect(worker, input.byte());
      case 2: return dispatcher_.worker_disconnected(worker, link_.get(), now_);
      case 3: return dispatcher_.tick(now_);
      case 4: return (void)dispatcher_.cancel(1 + input.byte() % 4, now_);
      case 5: return tell(worker, plausible(input));
      default: {
        v1::WorkerMessage message;
        if (message.ParseFromString(input.text(input.byte()))) tell(worker, message);
      }
    }
  }

  void submit() {
    NewJob job;
    job.kind = "discharge";
    job.key = "k" + std::to_string(++submitted_);
    job.filling_key = "f";
    (void)dispatcher_.submit({{job}, ""}, now_);
  }

  void connect(const std::string& worker, std::uint8_t held) {
    v1::WorkerHello hello;
    hello.set_worker_id(worker);
    hello.set_slots(1 + held % 3);
    hello.add_kinds("discharge");
    if (held > 100) hello.add_held()->set_task(task_name(held % 8));
    dispatcher_.worker_connected(hello, link_, now_);
  }

  // A message about a task that may exist.
  v1::WorkerMessage plausible(Bytes& input) {
    v1::WorkerMessage message;
    const std::string task = task_name(1 + input.byte() % 6);
    const std::uint8_t detail = input.byte();
    switch (input.byte() % 5) {
      case 0: message.mutable_heartbeat()->add_held()->set_task(task); break;
      case 1: message.mutable_progress()->set_task(task); break;
      case 2:
        message.mutable_finished()->set_task(task);
        message.mutable_finished()->set_outcome(static_cast<v1::TaskFinished::Outcome>(detail % 9));
        break;
      case 3:
        message.mutable_checkpointed()->set_task(task);
        message.mutable_checkpointed()->add_files()->set_name(input.text(detail % 16));
        break;
      default:
        message.mutable_filling_stored()->set_task(task);
        message.mutable_filling_stored()->set_filling_key("f");
    }
    return message;
  }

  void tell(const std::string& worker, const v1::WorkerMessage& message) {
    switch (message.what_case()) {
      case v1::WorkerMessage::kHeartbeat: return dispatcher_.heartbeat(worker, message.heartbeat(), now_);
      case v1::WorkerMessage::kProgress: return dispatcher_.task_progress(worker, message.progress(), now_);
      case v1::WorkerMessage::kFinished: return dispatcher_.task_finished(worker, message.finished(), now_);
      case v1::WorkerMessage::kCheckpointed: return dispatcher_.task_checkpointed(worker, message.checkpointed(), now_);
      case v1::WorkerMessage::kFillingStored: return dispatcher_.filling_stored(worker, message.filling_stored(), now_);
      default: return;
    }
  }

  Now now_{1'000'000, 1000};
  Database database_{":memory:"};
  SqliteJobStore store_;
  Dispatcher dispatcher_;
  std::shared_ptr<DeafLink> link_ = std::make_shared<DeafLink>();
  int submitted_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  World world;
  Bytes input(data, size);
  for (int steps = 0; !input.empty() && steps < 200; ++steps) world.step(input);
  world.check();
  return 0;
}
