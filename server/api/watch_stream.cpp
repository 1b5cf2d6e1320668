#include "server/api/watch_stream.h"

#include "server/api/watch_reactor.h"

namespace granary::server {

grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Backend& backend,
                                                  const v1::WatchJobRequest& request) {
  const JobId job = job_id_from(request.name()).value_or(0);  // 0 is no job
  auto watch = [&backend, job, name = request.name(),
                after = request.after_sequence()](std::shared_ptr<Watcher> watcher) -> Status {
    if (job == 0)
      return Error{ErrorCode::not_found, "no job '" + name + "', names look like jobs/17", ""};
    return backend.dispatcher.watch(job, after, std::move(watcher));
  };
  auto unwatch = [&backend, job](const Watcher* watcher) {
    backend.dispatcher.unwatch(job, watcher);
  };
  // State changes are few and each must arrive; of progress only the latest matters.
  const auto replaces = [](const v1::JobEvent& last, const v1::JobEvent& next) {
    return last.has_progress() && next.has_progress();
  };
  return new WatchReactor<v1::JobEvent, Watcher>(backend,
                                                 {std::move(watch), std::move(unwatch), replaces});
}

}  // namespace granary::server
