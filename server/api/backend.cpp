#include "server/api/backend.h"

namespace granary::server {

Now system_now() {
  using std::chrono::duration_cast;
  using std::chrono::milliseconds;
  return {duration_cast<milliseconds>(std::chrono::system_clock::now().time_since_epoch()).count(),
          duration_cast<milliseconds>(std::chrono::steady_clock::now().time_since_epoch()).count()};
}

std::string owner_of(const grpc::CallbackServerContext& context) {
  const auto names = context.auth_context()->FindPropertyValues("granary-owner");
  return names.empty() ? "local" : std::string(names[0].data(), names[0].size());
}

grpc::Status to_grpc(const Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const Error& error = status.error();
  // The field path travels as the binary detail, so that clients need not parse the message.
  return {static_cast<grpc::StatusCode>(error.code), error.message, error.field_path};
}

grpc::Status to_grpc(const Status& status, grpc::CallbackServerContext* context) {
  if (!status.ok() && status.error().retry_after_ms > 0)
    context->AddTrailingMetadata("grpc-retry-pushback-ms", std::to_string(status.error().retry_after_ms));
  return to_grpc(status);
}

namespace {

// By way of OwnerThread::post or OwnerThread::read.
grpc::ServerUnaryReactor* answer_by(void (OwnerThread::*way)(OwnerThread::Work, OwnerThread::Reply),
                                    Backend& backend, grpc::CallbackServerContext* context,
                                    std::function<Status()> work) {
  backend.touch();
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  auto outcome = std::make_shared<Status>(Done{});
  (backend.owner.*way)([work = std::move(work), outcome] { *outcome = work(); },
                       [reactor, context, outcome](const Status& committed) {
                         reactor->Finish(to_grpc(committed.ok() ? *outcome : committed, context));
                       });
  return reactor;
}

}  // namespace

grpc::ServerUnaryReactor* answer_on_owner(Backend& backend, grpc::CallbackServerContext* context,
                                          std::function<Status()> work) {
  return answer_by(&OwnerThread::post, backend, context, std::move(work));
}

grpc::ServerUnaryReactor* look_on_owner(Backend& backend, grpc::CallbackServerContext* context,
                                        std::function<Status()> work) {
  return answer_by(&OwnerThread::read, backend, context, std::move(work));
}

}  // namespace granary::server
