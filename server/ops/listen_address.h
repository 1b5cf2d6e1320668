// Where the server may listen. Without TLS and a token only this machine may connect.
#pragma once

#include <string>

#include "proto/contract/result.h"

namespace granary::server {

// "unix:PATH", "127.0.0.1:PORT", "localhost:PORT" or "[::1]:PORT"; port 0 = any free one. Every other
// HOST:PORT only when `is_guarded` (TLS and tokens are configured). FAILED_PRECONDITION otherwise.
Status check_listen_address(const std::string& address, bool is_guarded);

}  // namespace granary::server
