#include "server/api/study_watch_stream.h"

#include "server/api/watch_reactor.h"

namespace granary::server {

grpc::ServerWriteReactor<v1::Study>* watch_study(Backend& backend,
                                                 const v1::WatchStudyRequest& request) {
  // Number 0 is no study: the ordinary "not found" answers.
  const StudyId study = study_id_from(request.name()).value_or(0);
  auto watch = [&backend, study](std::shared_ptr<StudyWatcher> watcher) {
    return backend.studies.watch(study, std::move(watcher));
  };
  auto unwatch = [&backend, study](const StudyWatcher* watcher) {
    backend.studies.unwatch(study, watcher);
  };
  const auto replaces = [](const v1::Study&, const v1::Study&) { return true; };
  return new WatchReactor<v1::Study, StudyWatcher>(
      backend, {std::move(watch), std::move(unwatch), replaces});
}

}  // namespace granary::server
