// granary.v1.Query: SQL in, rows out. Queries run on a few threads of their own, never on the owner
// thread; each reads through its own read-only connection.
#pragma once

#include <filesystem>

#include "granary/v1/query.grpc.pb.h"
#include "server/api/backend.h"
#include "server/api/query_threads.h"

namespace granary::server {

class QueryService : public v1::Query::CallbackService {
 public:
  QueryService(Backend& backend, std::filesystem::path database)
      : backend_(backend), database_(std::move(database)) {}

  grpc::ServerWriteReactor<v1::QueryRows>* Run(grpc::CallbackServerContext*,
                                               const v1::QueryRequest*) override;
  grpc::ServerUnaryReactor* GetSchema(grpc::CallbackServerContext*, const v1::GetSchemaRequest*,
                                      v1::GetSchemaResponse*) override;

 private:
  Backend& backend_;
  std::filesystem::path database_;
  QueryThreads threads_;
};

}  // namespace granary::server
