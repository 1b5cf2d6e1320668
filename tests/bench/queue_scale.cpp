// The queue at full size: one granaryd, simulated workers, real gRPC on a Unix socket.
//   queue_scale [--jobs 1000000] [--workers 100]
// Prints one line per figure with PERFORMANCE's target; results are written down in tests/README.md.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <thread>

#include "tests/support/program.h"
#include "tests/support/queue_client.h"
#include "tests/support/simulated_worker.h"

namespace {

using namespace granary::test;
using Clock = std::chrono::steady_clock;

double seconds_of(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double p99_ms(int count, const std::function<void(int)>& call) {
  std::vector<double> ms;
  for (int i = 0; i < count; ++i) ms.push_back(1000 * seconds_of([&] { call(i); }));
  return percentile(ms, 0.99);
}

double resident_mb(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  return 0;
}

void report(const char* what, double value, const char* unit, const char* target) {
  std::printf("%-58s %10.1f %-8s target %s\n", what, value, unit, target);
  std::fflush(stdout);
}

struct Workers {
  Workers(const std::string& address, int count) {
    for (int i = 0; i < count; ++i)
      all.push_back(std::make_unique<SimulatedWorker>(address, "simulated-" + std::to_string(i), 1));
  }
  std::uint64_t done() const {
    std::uint64_t sum = 0;
    for (const auto& worker : all) sum += worker->tasks_done();
    return sum;
  }
  std::vector<double> stop() {
    std::vector<double> ms;
    for (const auto& worker : all) {
      worker->stop();
      const auto own = worker->lease_ms();
      ms.insert(ms.end(), own.begin(), own.end());
    }
    return ms;
  }
  std::vector<std::unique_ptr<SimulatedWorker>> all;
};

void one_by_one(const std::string& address, std::uint64_t first) {
  constexpr int kClients = 8, kEach = 500;
  const double seconds = seconds_of([&] {
    std::vector<std::thread> clients;
    for (int i = 0; i < kClients; ++i)
      clients.emplace_back([&, i] {
        QueueClient client(address);
        for (int k = 0; k < kEach; ++k) client.submit(first + static_cast<std::uint64_t>(i * kEach + k), 1);
      });
    for (auto& client : clients) client.join();
  });
  report("accepted one by one, eight clients", kClients * kEach / seconds, "jobs/s", ">= 1000");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Queue at full size"};
  std::uint64_t jobs = 1'000'000;
  int worker_count = 100;
  app.add_option("--jobs", jobs, "jobs in the queue");
  app.add_option("--workers", worker_count, "simulated workers");
  CLI11_PARSE(app, argc, argv);
  ScratchDirectory scratch;
  const std::string address = "unix:" + scratch.file("granaryd.sock");
  Program server({.command = {GRANARY_BIN "/granaryd", "--data", scratch.file("data"), "--listen", address,
                              "--max-jobs-per-s", "10000000"},
                  .environment = {}, .input = "", .on_terminal = false});
  if (!server.prints("listening on")) return 1;
  QueueClient client(address);
  const double submit_s = seconds_of([&] {
    for (std::uint64_t i = 0; i < jobs; i += 1000) client.submit(i, std::min<std::uint64_t>(1000, jobs - i));
  });
  report("accepted in batches of 1000", static_cast<double>(jobs) / submit_s, "jobs/s", ">= 5000");
  one_by_one(address, jobs);
  report("list, first page of 100, p99", p99_ms(200, [&](int) { client.list(100); }), "ms", "< 10");
  report("get, p99", p99_ms(500, [&](int i) { client.get("jobs/" + std::to_string(1 + i * 17)); }), "ms", "< 10");
  report("submit one, p99", p99_ms(300, [&](int i) { client.submit(jobs + 100'000 + static_cast<std::uint64_t>(i), 1); }), "ms", "< 10");
  report("server memory with all waiting", resident_mb(server.pid()), "MB", "< 300");

  Workers workers(address, worker_count);
  std::this_thread::sleep_for(std::chrono::seconds(1));  // connections
  const std::uint64_t before = workers.done();
  const double window_s = seconds_of([] { std::this_thread::sleep_for(std::chrono::seconds(10)); });
  report("no-op tasks dispatched", static_cast<double>(workers.done() - before) / window_s, "tasks/s", ">= 1000");
  report("list while dispatching, p99", p99_ms(200, [&](int) { client.list(100); }), "ms", "< 10");
  report("server memory while dispatching", resident_mb(server.pid()), "MB", "< 300");
  workers.stop();

  // A lease without a crowd: one worker, the whole queue waiting.
  Workers lone(address, 1);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  report("lease (result told to next task held), p99", percentile(lone.stop(), 0.99), "ms", "< 10");

  const std::string watched = client.submit(jobs + 200'000, 1).at(0);
  std::vector<std::unique_ptr<QueueWatcher>> watchers;
  for (int i = 0; i < 50; ++i) watchers.push_back(std::make_unique<QueueWatcher>(address, watched, i % 5 == 0));
  report("submit under 50 watchers, ten stuck, p99",
         p99_ms(300, [&](int i) { client.submit(jobs + 300'000 + static_cast<std::uint64_t>(i), 1); }), "ms", "answered");
  watchers.clear();
  server.signal(SIGTERM);
  return server.wait(std::chrono::seconds(60));
}
