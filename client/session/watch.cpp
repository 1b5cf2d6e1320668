// Session::watch: a stream that outlives its connection. Every event has a sequence number; a new
// stream asks for what comes after the last one seen, so nothing is shown twice and no state change
// is missed.
#include <optional>

#include "client/session/link.h"
#include "proto/contract/job_state.h"

namespace granary::session {
namespace {

constexpr BackoffLimits kReconnect{.first_s = 0.1, .longest_s = 5, .patience_s = 300};
constexpr int kTriesBeforeNotice = 4;  // about a second: a restart of the server is no news

// A stream that ended with one of these says nothing about the job.
bool is_broken_stream(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::OK:  // the server drains
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::INTERNAL:
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return true;
    default:
      return false;
  }
}

struct StreamEnd {
  grpc::Status status;
  bool job_ended = false;
  bool heard = false;  // at least one event came
};

StreamEnd read_stream(Connection& connection, v1::WatchJobRequest& request, const EventSink& sink,
                      Interrupt& interrupt) {
  StreamEnd end;
  const auto context = connection.stream_context();
  const Interrupt::Action cancel(interrupt, [&] { context->TryCancel(); });
  const auto reader = connection.jobs().Watch(context.get(), request);
  v1::JobEvent event;
  while (!end.job_ended && reader->Read(&event)) {
    request.set_after_sequence(std::max(request.after_sequence(), event.sequence()));
    end.heard = true;
    end.job_ended = event.what_case() == v1::JobEvent::kState && is_final(event.state());
    sink(event);
  }
  if (end.job_ended) context->TryCancel();  // nothing more comes; do not wait for the server
  end.status = reader->Finish();
  return end;
}

}  // namespace

Result<std::optional<v1::Job>> Session::watch(const std::string& name, const EventSink& sink,
                                              Interrupt& interrupt) {
  v1::WatchJobRequest request;
  request.set_name(name);
  Backoff backoff(kReconnect);
  int silent_tries = 0;
  for (;;) {
    const StreamEnd end = read_stream(link_->connection(), request, sink, interrupt);
    if (end.job_ended) {
      auto job = get(name);
      if (!job) return job.error();
      return std::optional<v1::Job>(*job);
    }
    if (interrupt.requested()) return std::optional<v1::Job>();
    if (!is_broken_stream(end.status)) return error_from(end.status);
    if (end.heard) backoff.reset();
    silent_tries = end.heard ? 0 : silent_tries + 1;
    if (silent_tries == kTriesBeforeNotice)
      link_->notice()(NoticeLevel::normal, "the server does not answer; trying for five minutes");
    const auto delay_s = backoff.next_delay_s(link_->jitter());
    if (!delay_s) return error_from(end.status);
    link_->notice()(NoticeLevel::detail, "the stream broke (" + end.status.error_message() +
                                             "); resuming after event " +
                                             std::to_string(request.after_sequence()));
    if (interrupt.wait_for_s(*delay_s)) return std::optional<v1::Job>();
    // A private server that cannot be started ends the watch; a named one may come back later.
    if (auto renewed = link_->renew(); !renewed) return renewed.error();
  }
}

}  // namespace granary::session
