#include "worker/agent/agent.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <thread>

#include "proto/contract/version.h"
#include "worker/agent/server_link.h"
#include "worker/agent/task_runner.h"

namespace granary::agent {
namespace {

using namespace std::chrono_literals;

constexpr auto kDrainLimit = 25s;

volatile std::sig_atomic_t stop_requested = 0;
void on_stop(int) {
  stop_requested = 1;
}

std::string host_name() {
  char name[256] = {};
  ::gethostname(name, sizeof name - 1);
  return name;
}

// Unique for each process, readable in listings.
std::string new_worker_id() {
  std::random_device random;
  char suffix[16];
  std::snprintf(suffix, sizeof suffix, "%08x", random());
  return host_name() + "-" + std::to_string(::getpid()) + "-" + suffix;
}

class Agent {
 public:
  Agent(const AgentConfig& config, const ServerAccess& access)
      : config_(config),
        folder_(config.work_dir / ("worker-" + std::to_string(::getpid()))),
        worker_id_(new_worker_id()),
        server_(access),
        link_(server_,
              {[this] { return hello(); }, [this](const auto& m) { receive(m); }}) {
    sweep_dead_workers();
    std::filesystem::create_directories(folder_);
  }

  int run() {
    std::thread heartbeat([this] { beat(); });
    const bool accepted = link_.run();
    {
      std::lock_guard lock(mutex_);
      ended_ = true;
      changed_.notify_all();
    }
    heartbeat.join();
    tasks_.clear();
    retired_.clear();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    return accepted ? 0 : 1;
  }

 private:
  v1::WorkerHello hello() {
    v1::WorkerHello hello;
    hello.set_worker_id(worker_id_);
    hello.set_host(host_name());
    hello.set_slots(config_.slots);
    hello.set_engine_version(kEngineVersion);
    hello.set_vector_path(config_.vector_path);
    for (const std::string& kind : config_.kinds) hello.add_kinds(kind);
    for (const auto& [name, value] : config_.tags) (*hello.mutable_tags())[name] = value;
    hello.set_pid(::getpid());
    std::lock_guard lock(mutex_);
    for (const auto& [name, task] : tasks_) *hello.add_held() = task->held();
    return hello;
  }

  void receive(const v1::ServerMessage& message) {
    if (message.has_welcome())
      welcome(message.welcome());
    else if (message.has_assign())
      assign(message.assign());
    else if (message.has_cancel())
      with_task(message.cancel().task(), [](TaskRunner& task) { task.cancel(); });
    else if (message.has_drop())
      with_task(message.drop().task(), [](TaskRunner& task) { task.drop(); });
    else if (message.has_acknowledged())
      with_task(message.acknowledged().task(), [](TaskRunner& task) { task.acknowledged(); });
  }

  void welcome(const v1::ServerWelcome& welcome) {
    spdlog::info("event=connected server={} worker={}", config_.server, worker_id_);
    std::lock_guard lock(mutex_);
    if (welcome.heartbeat_s() > 0) heartbeat_s_ = welcome.heartbeat_s();
    for (const auto& [name, task] : tasks_) task->say_again();
  }

  void assign(const v1::TaskAssignment& assignment) {
    spdlog::info("event=assigned task={} job={} attempt={}", assignment.task(), assignment.job(),
                 assignment.attempt());
    const std::string number = assignment.task().substr(assignment.task().find('/') + 1);
    TaskEnvironment environment{config_.program, folder_ / ("task-" + number), server_,
                                [this](const v1::WorkerMessage& message) { link_.send(message); },
                                [this](const std::string& task) { retire(task); }};
    std::lock_guard lock(mutex_);
    tasks_.emplace(assignment.task(),
                   std::make_unique<TaskRunner>(assignment, std::move(environment)));
  }

  void with_task(const std::string& name, const std::function<void(TaskRunner&)>& act) {
    std::lock_guard lock(mutex_);
    const auto found = tasks_.find(name);
    if (found != tasks_.end()) act(*found->second);
  }

  // Called by the task's own thread, which cannot join itself: the heartbeat thread does.
  void retire(const std::string& name) {
    std::lock_guard lock(mutex_);
    const auto found = tasks_.find(name);
    if (found == tasks_.end()) return;
    retired_.push_back(std::move(found->second));
    tasks_.erase(found);
    changed_.notify_all();
  }

  void beat() {
    std::unique_lock lock(mutex_);
    auto next = std::chrono::steady_clock::now();
    while (!ended_) {
      changed_.wait_for(lock, 50ms);
      auto retired = std::exchange(retired_, {});
      lock.unlock();
      retired.clear();
      lock.lock();
      if (stop_requested && !draining_) start_drain();
      if (draining_ && (tasks_.empty() || std::chrono::steady_clock::now() > drain_until_)) {
        lock.unlock();
        link_.stop();
        lock.lock();
      }
      if (std::chrono::steady_clock::now() < next) continue;
      next = std::chrono::steady_clock::now() +
             std::chrono::milliseconds(static_cast<int>(1000 * heartbeat_s_));
      const v1::WorkerMessage message = heartbeat();
      lock.unlock();
      link_.send(message);
      lock.lock();
    }
  }

  v1::WorkerMessage heartbeat() const {
    v1::WorkerMessage message;
    message.mutable_heartbeat()->set_draining(draining_);
    for (const auto& [name, task] : tasks_) *message.mutable_heartbeat()->add_held() = task->held();
    return message;
  }

  void start_drain() {
    spdlog::info("event=drain tasks={}", tasks_.size());
    draining_ = true;
    drain_until_ = std::chrono::steady_clock::now() + kDrainLimit;
    link_.send(heartbeat());
    for (const auto& [name, task] : tasks_) task->release();
  }

  // Folders of workers that were killed: their process is gone, nobody else cleans up.
  void sweep_dead_workers() {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(config_.work_dir, error)) {
      const std::string name = entry.path().filename().string();
      if (name.rfind("worker-", 0) != 0) continue;
      const pid_t pid = static_cast<pid_t>(std::atol(name.c_str() + 7));
      if (pid > 0 && ::kill(pid, 0) != 0 && errno == ESRCH)
        std::filesystem::remove_all(entry.path(), error);
    }
  }

  AgentConfig config_;
  std::filesystem::path folder_;
  std::string worker_id_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, std::unique_ptr<TaskRunner>> tasks_;
  std::vector<std::unique_ptr<TaskRunner>> retired_;
  double heartbeat_s_ = 2;
  bool draining_ = false;
  bool ended_ = false;
  std::chrono::steady_clock::time_point drain_until_;
  ServerPeer server_;
  ServerLink link_;
};

}  // namespace

int run_agent(const AgentConfig& config) {
  std::signal(SIGTERM, on_stop);
  std::signal(SIGINT, on_stop);
  std::signal(SIGPIPE, SIG_IGN);
  auto access = read_access(config.server, config.tls_ca, config.token_file);
  if (!access) {
    spdlog::error("{}", access.error().message);
    return 2;
  }
  return Agent(config, *access).run();
}

}  // namespace granary::agent
