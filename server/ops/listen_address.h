// Where the server may listen. Without TLS and a token only this machine may connect.
#pragma once

#include <string>

#include "proto/contract/result.h"

namespace granary::server {

// "unix:PATH", "127.0.0.1:PORT", "localhost:PORT" or "[::1]:PORT"; port 0 = any free one.
// FAILED_PRECONDITION for every other address.
Status check_listen_address(const std::string& address);

}  // namespace granary::server
