// One Watch call on a study: the latest state whenever it has changed.
#pragma once

#include <grpcpp/grpcpp.h>

#include "granary/v1/study.pb.h"
#include "server/api/backend.h"

namespace granary::server {

grpc::ServerWriteReactor<v1::Study>* watch_study(Backend& backend,
                                                 const v1::WatchStudyRequest& request);

}  // namespace granary::server
