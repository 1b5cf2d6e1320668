// granary.v1.Jobs: translates between messages and the dispatcher.
#pragma once

#include "granary/v1/job.grpc.pb.h"
#include "server/api/backend.h"

namespace granary::server {

class JobsService : public v1::Jobs::CallbackService {
 public:
  explicit JobsService(Backend& backend) : backend_(backend) {}

  grpc::ServerUnaryReactor* Submit(grpc::CallbackServerContext*, const v1::SubmitJobsRequest*,
                                   v1::SubmitJobsResponse*) override;
  grpc::ServerUnaryReactor* Get(grpc::CallbackServerContext*, const v1::GetJobRequest*,
                                v1::Job*) override;
  grpc::ServerUnaryReactor* List(grpc::CallbackServerContext*, const v1::ListJobsRequest*,
                                 v1::ListJobsResponse*) override;
  grpc::ServerWriteReactor<v1::JobEvent>* Watch(grpc::CallbackServerContext*,
                                                const v1::WatchJobRequest*) override;
  grpc::ServerUnaryReactor* Cancel(grpc::CallbackServerContext*, const v1::CancelJobRequest*,
                                   v1::Job*) override;
  grpc::ServerUnaryReactor* Retry(grpc::CallbackServerContext*, const v1::RetryJobRequest*,
                                  v1::Job*) override;
  grpc::ServerUnaryReactor* Delete(grpc::CallbackServerContext*, const v1::DeleteJobRequest*,
                                   v1::DeleteJobResponse*) override;
  grpc::ServerUnaryReactor* GetValues(grpc::CallbackServerContext*, const v1::GetValuesRequest*,
                                      v1::GetValuesResponse*) override;
  grpc::ServerUnaryReactor* GetLogs(grpc::CallbackServerContext*, const v1::GetLogsRequest*,
                                    v1::GetLogsResponse*) override;
  grpc::ServerWriteReactor<v1::DownloadChunk>* Download(grpc::CallbackServerContext*,
                                                        const v1::DownloadRequest*) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext*,
                                          const v1::GetServerInfoRequest*,
                                          v1::GetServerInfoResponse*) override;

 private:
  Backend& backend_;
};

}  // namespace granary::server
