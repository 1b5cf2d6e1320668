// granary.v1.Admin: what keeps a server in order.
#pragma once

#include <filesystem>
#include <mutex>
#include <thread>

#include "granary/v1/admin.grpc.pb.h"
#include "server/api/artifact_sender.h"
#include "server/api/backend.h"

namespace granary::server {

class AdminService : public v1::Admin::CallbackService {
 public:
  AdminService(Backend& backend, std::filesystem::path data) : backend_(backend), data_(std::move(data)) {}
  ~AdminService() override;

  grpc::ServerWriteReactor<v1::DownloadChunk>* Backup(grpc::CallbackServerContext*,
                                                      const v1::BackupRequest*) override;

 private:
  void make_and_send(ArtifactSender* sender);

  Backend& backend_;
  std::filesystem::path data_;
  std::mutex mutex_;
  bool busy_ = false;
  std::thread thread_;  // one copy at a time
};

}  // namespace granary::server
