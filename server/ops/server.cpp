#include "server/ops/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <atomic>
#include <condition_variable>
#include <future>
#include <mutex>
#include <thread>
#include <unordered_set>

#include "server/api/admin_service.h"
#include "server/api/jobs_service.h"
#include "server/api/query_service.h"
#include "server/api/studies_service.h"
#include "server/api/workers_service.h"
#include "server/jobs/retention.h"
#include "server/ops/audit_log.h"
#include "server/ops/call_observer.h"
#include "server/ops/data_lock.h"
#include "server/ops/disk_space.h"
#include "server/ops/listen_address.h"
#include "server/ops/metrics.h"
#include "server/store/database.h"
#include "server/store/sqlite_job_store.h"
#include "server/store/study_table.h"

namespace granary::server {
namespace {

constexpr std::chrono::hours kOrphanGrace{1};      // from an upload to the commit that refers to it
constexpr std::chrono::minutes kSweepInterval{10};
constexpr int kMaxMessageBytes = 64
                                 << 20;  // a batch of 10,000 scenes; single scenes are far smaller

class RunningServer : public Server {
 public:
  RunningServer(const ServerConfig& config, DataLock lock, std::unique_ptr<Metrics> metrics)
      : config_(config),
        lock_(std::move(lock)),
        metrics_(std::move(metrics)),
        audit_(config.data / "audit.log"),
        database_(config.data / "granary.db"),
        store_(database_.connection()),
        study_store_(database_.connection()),
        dispatcher_(store_, {.audit_one_in = config.audit_one_in}),
        retention_(store_, dispatcher_, config.keep_days),
        studies_(study_store_, store_, dispatcher_),
        artifacts_(config.data / "artifacts"),
        owner_(database_, hooks()),
        submissions_(config.max_jobs_per_s, 10 * config.max_jobs_per_s),
        backend_{owner_,   dispatcher_,  store_,       artifacts_,
                 studies_, study_store_, submissions_, {system_now().steady_ms}},
        jobs_(backend_),
        workers_(backend_),
        studies_service_(backend_),
        query_(backend_, config.data / "granary.db"),
        admin_(backend_, config.data) {
    owner_.post([this] { reload(); }, nullptr);
    constructed_ = true;
  }
  ~RunningServer() override { drain(); }

  Status listen() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    int port = 0;
    auto credentials = make_credentials(
        config_.access, config_.listen, [this](const auto& owner, const auto& path, const auto& code) {
          metrics_->call_ended(short_call(path).substr(0, 64), code, 0);
          audit_.append({system_now().wall_ms, owner, "", short_call(path), "", code});
        });
    if (!credentials) return credentials.error();
    builder.AddListeningPort(config_.listen, *credentials, &port);
    builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
    // A second server on the same port must fail, not share it.
    builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
    // Half-open connections of dead machines are found within 30 s.
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
    builder.RegisterService(&jobs_);
    builder.RegisterService(&workers_);
    builder.RegisterService(&studies_service_);
    builder.RegisterService(&query_);
    builder.RegisterService(&admin_);
    builder.experimental().SetInterceptorCreators(observing([this](const EndedCall& call) { observe(call); }));
    const ::mode_t mask = ::umask(0077);  // the socket file is for this user only
    grpc_ = builder.BuildAndStart();
    ::umask(mask);
    if (!grpc_)
      return Error{ErrorCode::failed_precondition,
                   "cannot listen on " + config_.listen + ": is the address in use?", "listen"};
    address_ = config_.listen;
    if (address_.rfind("unix:", 0) != 0)
      address_ = address_.substr(0, address_.rfind(':') + 1) + std::to_string(port);
    set_serving(true);
    sweeper_ = std::thread([this] { sweep_now_and_then(); });
    return Done{};
  }

  std::string address() const override { return address_; }
  std::string metrics_url() const override { return metrics_->url(); }
  bool wants_to_exit() const override { return wants_to_exit_; }

  void drain() override {
    if (!grpc_) return;
    set_serving(false);
    {
      std::lock_guard lock(sweep_mutex_);
      draining_ = true;
      sweep_wake_.notify_all();
    }
    if (sweeper_.joinable()) sweeper_.join();
    grpc_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(2));
    grpc_.reset();
    owner_.stop();
  }

 private:
  OwnerThread::Hooks hooks() {
    OwnerThread::Hooks hooks;
    hooks.before_commit = [this] { studies_.work(system_now()); };
    hooks.after_commit = [this] {
      for (const auto& effect : dispatcher_.take_effects()) effect();
      for (const auto& effect : studies_.take_effects()) effect();
      if (studies_.has_work()) owner_.post([] {}, nullptr);
    };
    hooks.after_failed_commit = [this] { recover(); };
    hooks.on_tick = [this] { tick(); };
    hooks.on_commit = [this](double seconds, bool ok) { metrics_->committed(seconds, ok); };
    return hooks;
  }

  void tick() {
    if (!constructed_) return;
    const Now now = system_now();
    watch_disk();
    dispatcher_.tick(now);
    if (const std::size_t removed = retention_.work(now); removed > 0)
      spdlog::info("event=retention removed={} keep_days={}", removed, config_.keep_days);
    metrics_->set(read_queue(now));
    if (config_.idle_exit_s <= 0) return;
    if (!dispatcher_.idle() || !studies_.idle()) backend_.touch();
    if (static_cast<double>(now.steady_ms - backend_.last_use_ms) > 1000 * config_.idle_exit_s)
      wants_to_exit_ = true;
  }

  void reload() {
    dispatcher_.reload(system_now());
    studies_.reload();
  }

  void observe(const EndedCall& call) {
    const std::string code =
        call.code == grpc::StatusCode::OK ? "OK" : std::string(to_string(static_cast<ErrorCode>(call.code)));
    metrics_->call_ended(short_call(call.path), code, call.seconds);
    if (is_audited(call.path))
      audit_.append({system_now().wall_ms, call.owner, call.peer, short_call(call.path), call.target, code});
  }

  QueueReading read_queue(Now now) {
    QueueReading reading{.waiting = dispatcher_.tally().waiting(),
                         .running = dispatcher_.tally().running(),
                         .free_slots = dispatcher_.free_slots(),
                         .disk_free_bytes = disk_free_bytes_,
                         .accepting = !intake_refused_,
                         .running_studies = studies_.running(),
                         .executions_ended = dispatcher_.executions_ended(),
                         .audits_ended = dispatcher_.audits_ended()};
    for (const v1::WorkerInfo& worker : dispatcher_.list_workers(now)) {
      if (worker.state() == "lost") continue;
      ++reading.workers;
      reading.slots += worker.slots();
    }
    return reading;
  }

  void watch_disk() {
    disk_free_bytes_ = free_bytes_of(config_.data);
    std::string refusal = intake_refusal(disk_free_bytes_, config_.kept_free_bytes, intake_refused_);
    if (refusal.empty() == intake_refused_)
      spdlog::warn("event=intake accepting={} free_mb={}", refusal.empty(), disk_free_bytes_ >> 20);
    intake_refused_ = !refusal.empty();
    dispatcher_.set_intake_refusal(std::move(refusal));
  }

  // A commit has failed (disk full): memory forgets what never became true, and workers tell again.
  void recover() {
    spdlog::error("event=commit_failed free_mb={}", free_bytes_of(config_.data) >> 20);
    dispatcher_.close_links();
    try {
      reload();
    } catch (const std::exception& error) {
      spdlog::critical("the database cannot be read: {}", error.what());
    }
  }

  // The list of what is referred to is taken on the owner thread, the files are removed here.
  std::size_t sweep_once() {
    std::unordered_set<std::string> referenced;
    std::promise<bool> listed;
    owner_.post(
        [this, &referenced] {
          for (std::string& name : store_.referenced_artifacts()) referenced.insert(std::move(name));
        },
        [&listed](const Status& status) { listed.set_value(status.ok()); });
    return listed.get_future().get() ? artifacts_.sweep(referenced, kOrphanGrace) : 0;
  }

  void sweep_now_and_then() {
    std::unique_lock lock(sweep_mutex_);
    while (!draining_) {
      lock.unlock();
      const std::size_t removed = sweep_once();
      if (removed > 0) spdlog::info("event=sweep removed={}", removed);
      lock.lock();
      sweep_wake_.wait_for(lock, kSweepInterval, [this] { return draining_; });
    }
  }

  void set_serving(bool serving) {
    auto* health = grpc_->GetHealthCheckService();
    health->SetServingStatus(serving);
    health->SetServingStatus("granary.v1.Jobs", serving);
    for (const char* service : {"Workers", "Studies", "Query", "Admin"})
      health->SetServingStatus(std::string("granary.v1.") + service, serving);
  }

  ServerConfig config_;
  DataLock lock_;
  std::unique_ptr<Metrics> metrics_;
  AuditLog audit_;
  Database database_;
  SqliteJobStore store_;
  StudyTable study_store_;
  Dispatcher dispatcher_;
  Retention retention_;
  StudyDirector studies_;
  ArtifactStore artifacts_;
  // Of the owner thread's ticks, which begin with it.
  std::atomic<bool> constructed_ = false;
  std::atomic<bool> wants_to_exit_ = false;
  bool intake_refused_ = false;
  std::uint64_t disk_free_bytes_ = 0;
  OwnerThread owner_;
  RateLimit submissions_;
  Backend backend_;
  JobsService jobs_;
  WorkersService workers_;
  StudiesService studies_service_;
  QueryService query_;
  AdminService admin_;
  std::unique_ptr<grpc::Server> grpc_;
  std::string address_;
  std::mutex sweep_mutex_;
  std::condition_variable sweep_wake_;
  bool draining_ = false;
  std::thread sweeper_;
};

}  // namespace

Result<std::unique_ptr<Server>> Server::start(const ServerConfig& config) {
  if (Status status = check_listen_address(config.listen, config.access.has_tls() && config.access.has_tokens()); !status) return status.error();
  std::error_code error;
  std::filesystem::create_directories(config.data, error);
  std::filesystem::permissions(config.data, std::filesystem::perms::owner_all, error);
  if (Status status = check_local_file_system(config.data); !status) return status.error();
  auto lock = DataLock::take(config.data);
  if (!lock) return lock.error();
  auto metrics = Metrics::start(config.metrics);
  if (!metrics) return metrics.error();
  try {
    auto server = std::make_unique<RunningServer>(config, std::move(*lock), std::move(*metrics));
    if (Status status = server->listen(); !status) return status.error();
    return std::unique_ptr<Server>(std::move(server));
  } catch (const std::exception& failure) {
    return Error{ErrorCode::internal, failure.what(), "data"};
  }
}

}  // namespace granary::server
