#include "server/ops/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/exposer.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "server/ops/listen_address.h"

namespace granary::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;

const prometheus::Histogram::BucketBoundaries kSeconds = {0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05,
                                                          0.1,    0.2,   0.5,   1,     5};

class PrometheusMetrics : public Metrics {
 public:
  explicit PrometheusMetrics(const std::string& address)
      : calls_(BuildCounter()
                   .Name("granary_calls_total")
                   .Help("RPCs ended, by call and gRPC code")
                   .Register(*registry_)),
        call_seconds_(BuildHistogram()
                          .Name("granary_call_seconds")
                          .Help("Duration of RPCs; streams last as long as they are open")
                          .Register(*registry_)),
        commit_seconds_(BuildHistogram()
                            .Name("granary_commit_seconds")
                            .Help("Duration of a group commit")
                            .Register(*registry_)
                            .Add({}, kSeconds)),
        commits_failed_(BuildCounter()
                            .Name("granary_commits_failed_total")
                            .Help("Group commits that failed, as with a full disk")
                            .Register(*registry_)
                            .Add({})),
        jobs_(BuildGauge().Name("granary_jobs").Help("Jobs by state").Register(*registry_)),
        workers_(BuildGauge()
                     .Name("granary_workers")
                     .Help("Connected workers")
                     .Register(*registry_)
                     .Add({})),
        slots_(BuildGauge()
                   .Name("granary_slots")
                   .Help("Slots of connected workers")
                   .Register(*registry_)),
        disk_free_(BuildGauge()
                       .Name("granary_disk_free_bytes")
                       .Help("Free on the disk of the data directory")
                       .Register(*registry_)
                       .Add({})),
        accepting_(BuildGauge()
                       .Name("granary_accepting")
                       .Help("1 = new jobs are accepted")
                       .Register(*registry_)
                       .Add({})),
        studies_(BuildGauge()
                     .Name("granary_studies_running")
                     .Help("Studies that propose or await trials")
                     .Register(*registry_)
                     .Add({})),
        executions_(BuildCounter()
                        .Name("granary_executions_total")
                        .Help("Executions of jobs ended, by outcome")
                        .Register(*registry_)),
        audits_(BuildCounter()
                    .Name("granary_audits_total")
                    .Help("Stored results computed again, by outcome of the comparison")
                    .Register(*registry_)) {
    if (address.empty()) return;
    exposer_ = std::make_unique<prometheus::Exposer>(address, 1);
    exposer_->RegisterCollectable(registry_);
    url_ = "http://" + address.substr(0, address.rfind(':') + 1) +
           std::to_string(exposer_->GetListeningPorts().at(0)) + "/metrics";
  }

  void call_ended(const std::string& call, const std::string& code, double seconds) override {
    calls_.Add({{"call", call}, {"code", code}}).Increment();
    call_seconds_.Add({{"call", call}}, kSeconds).Observe(seconds);
  }

  void committed(double seconds, bool ok) override {
    commit_seconds_.Observe(seconds);
    if (!ok) commits_failed_.Increment();
  }

  void set(const QueueReading& reading) override {
    jobs_.Add({{"state", "waiting"}}).Set(static_cast<double>(reading.waiting));
    jobs_.Add({{"state", "running"}}).Set(static_cast<double>(reading.running));
    workers_.Set(static_cast<double>(reading.workers));
    slots_.Add({{"use", "all"}}).Set(static_cast<double>(reading.slots));
    slots_.Add({{"use", "free"}}).Set(static_cast<double>(reading.free_slots));
    disk_free_.Set(static_cast<double>(reading.disk_free_bytes));
    accepting_.Set(reading.accepting ? 1 : 0);
    studies_.Set(static_cast<double>(reading.running_studies));
    set_counts(executions_, reading.executions_ended);
    set_counts(audits_, reading.audits_ended);
  }

  std::string url() const override { return url_; }

 private:
  static void set_counts(prometheus::Family<prometheus::Counter>& family,
                         const std::map<std::string, std::uint64_t>& counts) {
    for (const auto& [outcome, count] : counts) {
      prometheus::Counter& counter = family.Add({{"outcome", outcome}});
      counter.Increment(static_cast<double>(count) - counter.Value());
    }
  }

  std::shared_ptr<prometheus::Registry> registry_ = std::make_shared<prometheus::Registry>();
  prometheus::Family<prometheus::Counter>& calls_;
  prometheus::Family<prometheus::Histogram>& call_seconds_;
  prometheus::Histogram& commit_seconds_;
  prometheus::Counter& commits_failed_;
  prometheus::Family<prometheus::Gauge>& jobs_;
  prometheus::Gauge& workers_;
  prometheus::Family<prometheus::Gauge>& slots_;
  prometheus::Gauge& disk_free_;
  prometheus::Gauge& accepting_;
  prometheus::Gauge& studies_;
  prometheus::Family<prometheus::Counter>& executions_;
  prometheus::Family<prometheus::Counter>& audits_;
  std::unique_ptr<prometheus::Exposer> exposer_;
  std::string url_;
};

}  // namespace

Result<std::unique_ptr<Metrics>> Metrics::start(const std::string& address) {
  // Metrics have no tokens: this machine only, whatever guards the API.
  if (!address.empty()) {
    if (address.rfind("unix:", 0) == 0)
      return Error{ErrorCode::invalid_argument, "--metrics " + address + ": must be HOST:PORT on this machine", "metrics"};
    if (Status status = check_listen_address(address, false); !status)
      return Error{status.error().code, "--metrics " + address + ": must be HOST:PORT with a loopback address", "metrics"};
  }
  try {
    return std::unique_ptr<Metrics>(std::make_unique<PrometheusMetrics>(address));
  } catch (const std::exception&) {
    return Error{ErrorCode::failed_precondition, "--metrics " + address + ": cannot listen there, is the port in use?", "metrics"};
  }
}

}  // namespace granary::server
