#include "server/ops/call_observer.h"

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <chrono>
#include <set>

namespace granary::server {
namespace {

using grpc::experimental::InterceptionHookPoints;

// What the request is about, found by reflection: a field `name`, or the number of `items`.
std::string target_of(const google::protobuf::Message& request) {
  const auto* descriptor = request.GetDescriptor();
  const auto* reflection = request.GetReflection();
  const auto* name = descriptor->FindFieldByName("name");
  if (name && name->type() == google::protobuf::FieldDescriptor::TYPE_STRING && !name->is_repeated())
    return reflection->GetString(request, name).substr(0, 200);
  const auto* items = descriptor->FindFieldByName("items");
  if (items && items->is_repeated()) return std::to_string(reflection->FieldSize(request, items)) + " items";
  return {};
}

std::string owner_in(const grpc::ServerContextBase& context) {
  const auto auth = context.auth_context();
  if (!auth) return "local";
  const auto names = auth->FindPropertyValues("granary-owner");
  return names.empty() ? "local" : std::string(names[0].data(), names[0].size());
}

class Observing : public grpc::experimental::Interceptor {
 public:
  Observing(grpc::experimental::ServerRpcInfo* info, const CallObserver& observer)
      : info_(info), observer_(observer), wants_target_(is_audited(info->method())) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (wants_target_ && batch->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE) &&
        info_->type() != grpc::experimental::ServerRpcInfo::Type::BIDI_STREAMING &&
        batch->GetRecvMessage() != nullptr && target_.empty())
      target_ = target_of(*static_cast<const google::protobuf::Message*>(batch->GetRecvMessage()));
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) ended(batch->GetSendStatus());
    batch->Proceed();
  }

 private:
  void ended(const grpc::Status& status) const {
    const auto* context = info_->server_context();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start_;
    observer_({info_->method(), target_, owner_in(*context), context->peer(), status.error_code(), taken.count()});
  }

  grpc::experimental::ServerRpcInfo* info_;
  const CallObserver& observer_;
  bool wants_target_;
  std::string target_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class ObservingFactory : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit ObservingFactory(CallObserver observer) : observer_(std::move(observer)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override {
    return new Observing(info, observer_);
  }

 private:
  CallObserver observer_;
};

}  // namespace

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> observing(
    CallObserver observer) {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> factories;
  factories.push_back(std::make_unique<ObservingFactory>(std::move(observer)));
  return factories;
}

std::string short_call(const std::string& path) {
  constexpr std::string_view kPackage = "/granary.v1.";
  return path.rfind(kPackage, 0) == 0 ? path.substr(kPackage.size()) : path;
}

bool is_audited(const std::string& path) {
  static const std::set<std::string, std::less<>> kMethods = {
      "Submit", "Cancel", "Retry", "Delete", "Pause", "Resume", "Extend", "Backup", "Synchronize"};
  return kMethods.count(path.substr(path.rfind('/') + 1)) > 0;
}

}  // namespace granary::server
