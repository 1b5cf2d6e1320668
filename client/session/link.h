// What session.cpp, watch.cpp and download.cpp share: the current connection, how to get another
// one, and the rule for repeating a call. Internal to client/session.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <thread>

#include "client/session/backoff.h"
#include "client/session/connection.h"
#include "client/session/session.h"

namespace granary::session {

class Session::Link {
 public:
  Link(Settings settings, Notice notice)
      : settings_(std::move(settings)), notice_(std::move(notice)) {}

  // Opens a connection: to the named server, else to the private one, started when it is not there.
  Status connect();

  Connection& connection() { return *connection_; }
  const Notice& notice() const { return notice_; }
  double jitter() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  bool names_server() const { return settings_.names_server(); }

  // After UNAVAILABLE. A named server's channel reconnects by itself; the private one may have left
  // for good, so it is looked for, and started, again.
  Status renew() { return names_server() ? Status(Done{}) : connect(); }

  // `invoke(connection, context, response)` until it gives something else than UNAVAILABLE
  // (repeated for about ten seconds) or a full queue's retry delay.
  template <typename Response, typename Invoke>
  Result<Response> call(const Invoke& invoke);

 private:
  Result<Endpoint> named_endpoint() const;
  Result<std::shared_ptr<Connection>> connect_named() const;
  Result<std::shared_ptr<Connection>> connect_private() const;

  Settings settings_;
  Notice notice_;
  std::shared_ptr<Connection> connection_;
  std::mt19937_64 random_{std::random_device{}()};
};

std::string random_id();

// Seconds after which a refusing server wants to be asked again; gRPC's own name for it.
std::optional<double> server_retry_delay_s(const grpc::ClientContext& context);

template <typename Response, typename Invoke>
Result<Response> Session::Link::call(const Invoke& invoke) {
  Backoff backoff({.first_s = 0.1, .longest_s = 2, .patience_s = 10});
  for (;;) {
    Response response;
    const auto context = connection_->call_context();
    const grpc::Status status = invoke(*connection_, *context, &response);
    if (status.ok()) return response;
    const bool full = status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED;
    const auto wanted_s = full ? server_retry_delay_s(*context) : std::nullopt;
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE && !wanted_s)
      return error_from(status);
    const auto delay_s = backoff.next_delay_s(jitter(), wanted_s);
    if (!delay_s) return error_from(status);
    notice_(full ? NoticeLevel::normal : NoticeLevel::detail, "trying again: " + status.error_message());
    std::this_thread::sleep_for(std::chrono::duration<double>(*delay_s));
    if (auto renewed = renew(); !renewed) return renewed.error();
  }
}

}  // namespace granary::session
