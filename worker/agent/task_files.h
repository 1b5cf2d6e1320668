// The files of a task that travel: what an earlier execution left (checkpoint and sealed segments)
// and a stored filling come in before the engine starts; new checkpoints and the settled filling go
// out while it runs. Losing any of them costs time, never the job.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "granary/v1/worker.grpc.pb.h"
#include "worker/agent/server_peer.h"

namespace granary::agent {

class TaskFiles {
 public:
  using Send = std::function<void(const v1::WorkerMessage&)>;

  TaskFiles(const v1::TaskAssignment& assignment, std::filesystem::path folder,
            const ServerPeer& server, Send send);

  void fetch();  // before the engine starts
  void share();  // uploads what is new; from one thread at a time

 private:
  bool fetch_one(const v1::Artifact& artifact, const std::string& name);
  void share_filling();
  void share_checkpoint();
  bool upload_pinned(const std::string& name, v1::UploadChunk::Purpose purpose,
                     v1::Artifact* artifact);

  const v1::TaskAssignment& assignment_;
  std::filesystem::path folder_;
  const ServerPeer& server_;
  Send send_;
  bool filling_shared_ = false;
  std::filesystem::file_time_type checkpoint_time_{};
  std::map<std::string, v1::Artifact> shared_segments_;  // sealed segments never change
};

}  // namespace granary::agent
