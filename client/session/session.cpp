#include "client/session/session.h"

#include <fstream>
#include <sstream>

#include "client/session/link.h"
#include "client/session/private_server.h"

namespace granary::session {
namespace {

constexpr std::size_t kLargestSecretFile_bytes = 1 << 20;

Result<std::string> read_small_file(const Setting& setting) {
  std::ifstream file(setting.value, std::ios::binary);
  std::string text(kLargestSecretFile_bytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (text.empty())
    return Error{ErrorCode::invalid_argument,
                 setting.source + ": " + setting.value + " cannot be read or is empty", ""};
  return text;
}

std::string without_edge_blanks(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

bool stays_on_this_machine(const std::string& address) {
  for (const char* prefix : {"unix:", "localhost:", "127.", "[::1]:"})
    if (address.rfind(prefix, 0) == 0) return true;
  return false;
}

}  // namespace

std::string random_id() {
  std::random_device device;
  std::ostringstream id;
  id << std::hex;
  for (int i = 0; i < 4; ++i) id << device();
  return id.str();
}

std::optional<double> server_retry_delay_s(const grpc::ClientContext& context) {
  const auto& trailing = context.GetServerTrailingMetadata();
  const auto found = trailing.find("grpc-retry-pushback-ms");
  if (found == trailing.end()) return std::nullopt;
  const double delay_ms =
      std::atof(std::string(found->second.data(), found->second.size()).c_str());
  if (!(delay_ms >= 0)) return std::nullopt;
  return std::min(delay_ms / 1000, 30.0);
}

Result<Endpoint> Session::Link::named_endpoint() const {
  Endpoint endpoint{settings_[SettingKey::server].value, "", ""};
  const Setting& tls_ca = settings_[SettingKey::tls_ca];
  if (!tls_ca.value.empty() && endpoint.address.rfind("unix:", 0) != 0) {
    auto pem = read_small_file(tls_ca);
    if (!pem) return pem.error();
    endpoint.tls_ca_pem = *pem;
  }
  const Setting& token_file = settings_[SettingKey::token_file];
  if (!token_file.value.empty()) {
    auto token = read_small_file(token_file);
    if (!token) return token.error();
    endpoint.token = without_edge_blanks(*token);
    if (endpoint.tls_ca_pem.empty() && !stays_on_this_machine(endpoint.address))
      return Error{ErrorCode::permission_denied,
                   "a token is not sent in clear text to " + endpoint.address +
                       ": name the certificate authority with --tls-ca",
                   ""};
  }
  return endpoint;
}

Status Session::Link::connect() {
  auto connection = settings_.names_server() ? connect_named() : connect_private();
  if (!connection) return connection.error();
  connection_ = *connection;
  return Done{};
}

Result<std::shared_ptr<Connection>> Session::Link::connect_named() const {
  auto endpoint = named_endpoint();
  if (!endpoint) return endpoint.error();
  return Connection::open(*endpoint, kConnectTimeout);
}

Result<std::shared_ptr<Connection>> Session::Link::connect_private() const {
  return join_private_server(settings_,
                             [this](std::string_view text) { notice_(NoticeLevel::detail, text); });
}

Session::Session(std::unique_ptr<Link> link) : link_(std::move(link)) {}
Session::~Session() = default;

Result<std::unique_ptr<Session>> Session::open(const Settings& settings, Notice notice) {
  auto link = std::make_unique<Link>(settings, std::move(notice));
  if (auto connected = link->connect(); !connected) return connected.error();
  return std::unique_ptr<Session>(new Session(std::move(link)));
}

const std::string& Session::address() const {
  return link_->connection().address();
}

Status Session::reconnect() {
  return link_->renew();
}

Result<std::vector<std::string>> Session::submit(v1::SubmitJobsRequest request) {
  if (request.request_id().empty()) request.set_request_id(random_id());
  auto response = link_->call<v1::SubmitJobsResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.jobs().Submit(&context, request, answer);
      });
  if (!response) return response.error();
  return std::vector<std::string>(response->names().begin(), response->names().end());
}

Result<v1::Job> Session::get(const std::string& name) {
  v1::GetJobRequest request;
  request.set_name(name);
  return link_->call<v1::Job>([&](Connection& connection, grpc::ClientContext& context, auto* job) {
    return connection.jobs().Get(&context, request, job);
  });
}

Result<v1::ListJobsResponse> Session::list(const v1::ListJobsRequest& request) {
  return link_->call<v1::ListJobsResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.jobs().List(&context, request, answer);
      });
}

Result<v1::Job> Session::cancel(const std::string& name) {
  v1::CancelJobRequest request;
  request.set_name(name);
  return link_->call<v1::Job>([&](Connection& connection, grpc::ClientContext& context, auto* job) {
    return connection.jobs().Cancel(&context, request, job);
  });
}

Result<v1::Job> Session::retry(const std::string& name) {
  v1::RetryJobRequest request;
  request.set_name(name);
  int tries = 0;
  auto job =
      link_->call<v1::Job>([&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        ++tries;
        return connection.jobs().Retry(&context, request, answer);
      });
  // The answer to an earlier try was lost: the job is queued because we asked for it.
  if (!job && tries > 1 && job.error().code == ErrorCode::failed_precondition) return get(name);
  return job;
}

Status Session::remove(const std::string& name) {
  v1::DeleteJobRequest request;
  request.set_name(name);
  int tries = 0;
  auto response = link_->call<v1::DeleteJobResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        ++tries;
        return connection.jobs().Delete(&context, request, answer);
      });
  // The answer to an earlier try was lost: the job is gone because we deleted it.
  if (!response && tries > 1 && response.error().code == ErrorCode::not_found) return Done{};
  if (!response) return response.error();
  return Done{};
}

Result<v1::GetValuesResponse> Session::values(const std::string& name) {
  v1::GetValuesRequest request;
  request.set_name(name);
  return link_->call<v1::GetValuesResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.jobs().GetValues(&context, request, answer);
      });
}

Result<std::vector<std::string>> Session::logs(const std::string& name) {
  v1::GetLogsRequest request;
  request.set_name(name);
  auto response = link_->call<v1::GetLogsResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.jobs().GetLogs(&context, request, answer);
      });
  if (!response) return response.error();
  return std::vector<std::string>(response->lines().begin(), response->lines().end());
}

Result<v1::ListWorkersResponse> Session::workers() {
  return link_->call<v1::ListWorkersResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.workers().List(&context, v1::ListWorkersRequest(), answer);
      });
}

Result<v1::GetServerInfoResponse> Session::server_info() {
  return link_->call<v1::GetServerInfoResponse>(
      [&](Connection& connection, grpc::ClientContext& context, auto* answer) {
        return connection.jobs().GetServerInfo(&context, v1::GetServerInfoRequest(), answer);
      });
}

Status Session::health() {
  constexpr std::chrono::seconds kTimeout{2};
  Status serving = link_->connection().check_health(kTimeout);
  if (serving || link_->names_server()) return serving;
  // The private one was just leaving.
  if (auto renewed = link_->renew(); !renewed) return renewed;
  return link_->connection().check_health(kTimeout);
}

}  // namespace granary::session
