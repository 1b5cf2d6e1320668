// Session on studies and queries.
#include <optional>

#include "client/session/link.h"

namespace granary::session {
namespace {

constexpr BackoffLimits kReconnect{.first_s = 0.1, .longest_s = 5, .patience_s = 300};
constexpr std::uint32_t kTrialsPerPage = 500;

bool has_ended(const v1::Study& study) {
  return study.state() != v1::Study::RUNNING && study.state() != v1::Study::PAUSED;
}

// A stream that ended with one of these says nothing about the study.
bool is_broken_stream(const grpc::Status& status) {
  return status.ok() || status.error_code() == grpc::StatusCode::UNAVAILABLE ||
         status.error_code() == grpc::StatusCode::CANCELLED ||
         status.error_code() == grpc::StatusCode::INTERNAL;
}

struct StreamEnd {
  grpc::Status status;
  std::optional<v1::Study> last;
};

StreamEnd read_stream(Connection& connection, const v1::WatchStudyRequest& request,
                      const StudySink& sink, Interrupt& interrupt) {
  StreamEnd end;
  const auto context = connection.stream_context();
  const Interrupt::Action cancel(interrupt, [&] { context->TryCancel(); });
  const auto reader = connection.studies().Watch(context.get(), request);
  v1::Study study;
  while (!(end.last && has_ended(*end.last)) && reader->Read(&study)) {
    end.last = study;
    sink(study);
  }
  // Nothing more comes; do not wait for the server. A refusal must keep its own status.
  if (end.last && has_ended(*end.last)) context->TryCancel();
  end.status = reader->Finish();
  return end;
}

}  // namespace

Result<v1::Study> Session::submit_study(v1::SubmitStudyRequest request) {
  if (request.request_id().empty()) request.set_request_id(random_id());
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Submit(&context, request, study);
      });
}

Result<v1::Study> Session::get_study(const std::string& name) {
  v1::GetStudyRequest request;
  request.set_name(name);
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Get(&context, request, study);
      });
}

Result<v1::ListStudiesResponse> Session::list_studies(const v1::ListStudiesRequest& request) {
  return link_->call<v1::ListStudiesResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.studies().List(&context, request, answer);
      });
}

Result<v1::Study> Session::pause_study(const std::string& name) {
  v1::PauseStudyRequest request;
  request.set_name(name);
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Pause(&context, request, study);
      });
}

Result<v1::Study> Session::resume_study(const std::string& name) {
  v1::ResumeStudyRequest request;
  request.set_name(name);
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Resume(&context, request, study);
      });
}

Result<v1::Study> Session::extend_study(const v1::ExtendStudyRequest& request) {
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Extend(&context, request, study);
      });
}

Result<v1::Study> Session::cancel_study(const v1::CancelStudyRequest& request) {
  return link_->call<v1::Study>(
      [&](Connection& connection, grpc::ClientContext& context, auto* study) {
        return connection.studies().Cancel(&context, request, study);
      });
}

Result<std::vector<v1::Trial>> Session::trials(const std::string& name) {
  v1::ListTrialsRequest request;
  request.set_name(name);
  request.set_page_size(kTrialsPerPage);
  std::vector<v1::Trial> trials;
  for (;;) {
    auto page = link_->call<v1::ListTrialsResponse>(
        [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
          return connection.studies().ListTrials(&context, request, answer);
        });
    if (!page) return page.error();
    trials.insert(trials.end(), page->trials().begin(), page->trials().end());
    if (page->next_page_token().empty()) return trials;
    request.set_page_token(page->next_page_token());
  }
}

Result<std::optional<v1::Study>> Session::watch_study(const std::string& name,
                                                      const StudySink& sink, Interrupt& interrupt) {
  v1::WatchStudyRequest request;
  request.set_name(name);
  Backoff backoff(kReconnect);
  for (;;) {
    const StreamEnd end = read_stream(link_->connection(), request, sink, interrupt);
    if (end.last && has_ended(*end.last)) return end.last;
    if (interrupt.requested()) return std::optional<v1::Study>();
    if (!is_broken_stream(end.status)) return error_from(end.status);
    if (end.last) backoff.reset();
    const auto delay_s = backoff.next_delay_s(link_->jitter());
    if (!delay_s) return error_from(end.status);
    if (interrupt.wait_for_s(*delay_s)) return std::optional<v1::Study>();
    if (auto renewed = link_->renew(); !renewed) return renewed.error();
  }
}

Status Session::query(const v1::QueryRequest& request, const RowsSink& sink) {
  for (int tries = 0;; ++tries) {
    const auto context = link_->connection().stream_context();
    const auto reader = link_->connection().query().Run(context.get(), request);
    v1::QueryRows rows;
    bool any = false;
    Status taken = Done{};
    while (taken && reader->Read(&rows)) {
      any = true;
      taken = sink(rows);
    }
    if (!taken) {
      context->TryCancel();
      reader->Finish();
      return taken;
    }
    const grpc::Status status = reader->Finish();
    if (status.ok()) return Done{};
    if (any || tries > 0 || status.error_code() != grpc::StatusCode::UNAVAILABLE)
      return error_from(status);
    if (auto renewed = link_->renew(); !renewed) return renewed;
  }
}

Result<v1::GetSchemaResponse> Session::query_schema() {
  return link_->call<v1::GetSchemaResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.query().GetSchema(&context, v1::GetSchemaRequest(), answer);
      });
}

}  // namespace granary::session
