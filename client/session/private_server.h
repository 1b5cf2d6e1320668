// The private server of a data directory: joined when it runs, started when it does not.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "client/session/connection.h"
#include "client/session/settings.h"
#include "proto/contract/result.h"

namespace granary::session {

// Seconds after its last use at which the private server leaves.
inline constexpr int kPrivateIdleExit_s = 60;

// A connection to a serving server of the data directory of `settings`. Clients that call this at
// once take turns by a lock, so one starts it and the others join. UNAVAILABLE with the end of its
// log when it does not come up.
Result<std::shared_ptr<Connection>> join_private_server(
    const Settings& settings, const std::function<void(std::string_view)>& notice);

// A connection when a server at `address` says SERVING within the timeout, else null.
std::shared_ptr<Connection> serving_connection(const std::string& address,
                                               std::chrono::milliseconds timeout);

}  // namespace granary::session
