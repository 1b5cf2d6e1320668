#include "tests/support/queue_client.h"

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <stdexcept>

#include "granary/v1/job.grpc.pb.h"

namespace granary::test {
namespace {

std::shared_ptr<grpc::Channel> channel_to(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
  arguments.SetMaxReceiveMessageSize(64 << 20);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

void require(const grpc::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

}  // namespace

struct QueueClient::Stubs {
  explicit Stubs(const std::string& address) : jobs(v1::Jobs::NewStub(channel_to(address))) {}
  std::unique_ptr<v1::Jobs::Stub> jobs;
};

QueueClient::QueueClient(const std::string& address) : stubs_(std::make_unique<Stubs>(address)) {}
QueueClient::~QueueClient() = default;

std::vector<std::string> QueueClient::submit(std::uint64_t first, std::uint64_t count) {
  v1::SubmitJobsRequest request;
  for (std::uint64_t i = first; i < first + count; ++i) {
    v1::Scene& scene = *request.add_items()->mutable_scene();
    scene.set_seed(i);
    v1::Discharge& discharge = *scene.mutable_discharge();
    discharge.mutable_particles()->set_count(20);
    discharge.mutable_particles()->set_diameter_min_m(0.01);
    discharge.mutable_particles()->set_density_kg_per_m3(2200);
    discharge.set_friction_pp_deg(30);
    discharge.set_friction_pw_deg(20);
    discharge.set_rotation_rad_per_s(10.5);
  }
  v1::SubmitJobsResponse response;
  grpc::ClientContext context;
  require(stubs_->jobs->Submit(&context, request, &response));
  return {response.names().begin(), response.names().end()};
}

std::size_t QueueClient::list(std::uint32_t page_size) {
  v1::ListJobsRequest request;
  request.set_page_size(page_size);
  v1::ListJobsResponse response;
  grpc::ClientContext context;
  require(stubs_->jobs->List(&context, request, &response));
  return static_cast<std::size_t>(response.jobs_size());
}

std::uint64_t QueueClient::count_all(std::uint32_t page_size) {
  v1::ListJobsRequest request;
  request.set_page_size(page_size);
  std::uint64_t count = 0;
  for (;;) {
    v1::ListJobsResponse response;
    grpc::ClientContext context;
    require(stubs_->jobs->List(&context, request, &response));
    count += static_cast<std::uint64_t>(response.jobs_size());
    if (response.next_page_token().empty()) return count;
    request.set_page_token(response.next_page_token());
  }
}

void QueueClient::get(const std::string& job) {
  v1::GetJobRequest request;
  request.set_name(job);
  v1::Job response;
  grpc::ClientContext context;
  require(stubs_->jobs->Get(&context, request, &response));
}

struct QueueWatcher::Stream {
  Stream(const std::string& address, const std::string& job, bool stuck)
      : jobs(v1::Jobs::NewStub(channel_to(address))) {
    v1::WatchJobRequest request;
    request.set_name(job);
    stream = jobs->Watch(&context, request);
    if (!stuck)
      reader = std::thread([this] {
        v1::JobEvent event;
        while (stream->Read(&event)) ++events;
      });
  }
  ~Stream() {
    context.TryCancel();
    if (reader.joinable()) reader.join();
    (void)stream->Finish();
  }
  std::unique_ptr<v1::Jobs::Stub> jobs;
  grpc::ClientContext context;
  std::unique_ptr<grpc::ClientReader<v1::JobEvent>> stream;
  std::atomic<std::uint64_t> events = 0;
  std::thread reader;
};

QueueWatcher::QueueWatcher(const std::string& address, const std::string& job, bool stuck)
    : stream_(std::make_unique<Stream>(address, job, stuck)) {}
QueueWatcher::~QueueWatcher() = default;
std::uint64_t QueueWatcher::events() const { return stream_->events; }

}  // namespace granary::test
