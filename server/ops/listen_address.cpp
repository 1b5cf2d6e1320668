#include "server/ops/listen_address.h"

#include <charconv>

namespace granary::server {
namespace {

constexpr std::size_t kMaxSocketPath = 107;  // sockaddr_un, without its terminating zero

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && rest == text.data() + text.size() && port <= 65535;
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "[::1]" || host.substr(0, 4) == "127.";
}

Error refuse(const std::string& address, const std::string& why) {
  return {ErrorCode::failed_precondition, "--listen " + address + ": " + why, "listen"};
}

}  // namespace

Status check_listen_address(const std::string& address, bool is_guarded) {
  if (address.rfind("unix:", 0) == 0) {
    if (address.size() - 5 > kMaxSocketPath)
      return refuse(
          address, "a socket path may have at most 107 bytes, choose a shorter --data or --listen");
    return Done{};
  }
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || !is_port(std::string_view(address).substr(colon + 1)))
    return refuse(address, "must be unix:PATH or HOST:PORT");
  if (!is_guarded && !is_loopback(std::string_view(address).substr(0, colon)))
    return refuse(
        address,
        "is not a loopback address, which needs TLS and a token; use 127.0.0.1:PORT or unix:PATH");
  return Done{};
}

}  // namespace granary::server
