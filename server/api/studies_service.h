// granary.v1.Studies: translates between messages and the study director.
#pragma once

#include "granary/v1/study.grpc.pb.h"
#include "server/api/backend.h"

namespace granary::server {

class StudiesService : public v1::Studies::CallbackService {
 public:
  explicit StudiesService(Backend& backend) : backend_(backend) {}

  grpc::ServerUnaryReactor* Submit(grpc::CallbackServerContext*, const v1::SubmitStudyRequest*,
                                   v1::Study*) override;
  grpc::ServerUnaryReactor* Get(grpc::CallbackServerContext*, const v1::GetStudyRequest*,
                                v1::Study*) override;
  grpc::ServerUnaryReactor* List(grpc::CallbackServerContext*, const v1::ListStudiesRequest*,
                                 v1::ListStudiesResponse*) override;
  grpc::ServerWriteReactor<v1::Study>* Watch(grpc::CallbackServerContext*,
                                             const v1::WatchStudyRequest*) override;
  grpc::ServerUnaryReactor* Pause(grpc::CallbackServerContext*, const v1::PauseStudyRequest*,
                                  v1::Study*) override;
  grpc::ServerUnaryReactor* Resume(grpc::CallbackServerContext*, const v1::ResumeStudyRequest*,
                                   v1::Study*) override;
  grpc::ServerUnaryReactor* Extend(grpc::CallbackServerContext*, const v1::ExtendStudyRequest*,
                                   v1::Study*) override;
  grpc::ServerUnaryReactor* Cancel(grpc::CallbackServerContext*, const v1::CancelStudyRequest*,
                                   v1::Study*) override;
  grpc::ServerUnaryReactor* ListTrials(grpc::CallbackServerContext*, const v1::ListTrialsRequest*,
                                       v1::ListTrialsResponse*) override;

 private:
  Backend& backend_;
};

}  // namespace granary::server
