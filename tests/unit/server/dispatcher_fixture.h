// A dispatcher on a real SQLite file in memory, with a clock made by hand and links that only listen.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "server/jobs/dispatcher.h"
#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"

namespace granary::server {

class FakeLink : public WorkerLink {
 public:
  void send(v1::ServerMessage message) override { sent.push_back(std::move(message)); }
  void close() override { closed = true; }

  std::vector<std::string> assigned() const {
    std::vector<std::string> jobs;
    for (const auto& message : sent)
      if (message.has_assign()) jobs.push_back(message.assign().job());
    return jobs;
  }
  std::string last_task() const {
    for (auto message = sent.rbegin(); message != sent.rend(); ++message)
      if (message->has_assign()) return message->assign().task();
    return "";
  }
  template <typename Has>
  int count(Has has) const {
    return static_cast<int>(std::count_if(sent.begin(), sent.end(), has));
  }

  std::vector<v1::ServerMessage> sent;
  bool closed = false;
};

class RecordingWatcher : public Watcher {
 public:
  void deliver(const v1::JobEvent& event) override { events.push_back(event); }
  void finish() override { finished = true; }
  std::vector<v1::JobState> states() const {
    std::vector<v1::JobState> out;
    for (const auto& event : events)
      if (!event.has_progress()) out.push_back(event.state());
    return out;
  }
  std::vector<v1::JobEvent> events;
  bool finished = false;
};

class DispatcherTest : public testing::Test {
 protected:
  DispatcherTest() { dispatcher.reload(now); }

  void settle() {
    for (const auto& effect : dispatcher.take_effects()) effect();
  }
  JobId submit(const std::string& key = "k", int priority = 0, bool fresh = true) {
    NewJob job;
    job.kind = "discharge";
    job.key = key;
    job.priority = priority;
    job.fresh = fresh;
    auto ids = dispatcher.submit({{job}, ""}, now);
    settle();
    return ids.value()[0];
  }
  std::shared_ptr<FakeLink> connect(const std::string& id, unsigned slots = 1,
                                    const std::vector<std::string>& held = {}) {
    auto link = std::make_shared<FakeLink>();
    v1::WorkerHello hello;
    hello.set_worker_id(id);
    hello.set_slots(slots);
    hello.add_kinds("discharge");
    for (const std::string& task : held) hello.add_held()->set_task(task);
    dispatcher.worker_connected(hello, link, now);
    settle();
    return link;
  }
  void finish(const std::string& worker, const std::string& task,
              v1::TaskFinished::Outcome outcome = v1::TaskFinished::COMPLETE) {
    v1::TaskFinished message;
    message.set_task(task);
    message.set_outcome(outcome);
    message.mutable_artifact()->set_sha256("from " + worker);
    message.mutable_result()->set_kind("discharge");
    dispatcher.task_finished(worker, message, now);
    settle();
  }
  void pass(std::int64_t ms) {
    now.wall_ms += ms;
    now.steady_ms += ms;
    dispatcher.tick(now);
    settle();
  }
  v1::JobState state(JobId id) { return dispatcher.find(id)->state; }

  Now now{1'700'000'000'000, 1000};
  Database database{":memory:"};
  SqliteJobStore store{database.connection()};
  Dispatcher dispatcher{store, {100, 50}};
};

}  // namespace granary::server
