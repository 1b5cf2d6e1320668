#include "server/jobs/stored_filling.h"

#include "proto/contract/job_state.h"
#include "proto/contract/resolve.h"

namespace granary::server {
namespace {

constexpr const char* kField = "discharge.stored_filling";

Error refuse(ErrorCode code, const std::string& what) {
  return {code, std::string(kField) + ": " + what, kField};
}

// A bed fits the bucket it settled in, with the disks it was made of.
Status check_fits(const v1::Discharge& wanted, const v1::Discharge& source,
                  const std::string& name) {
  const auto differs = [&](const char* field) {
    return refuse(ErrorCode::invalid_argument,
                  name + " filled a bucket with another discharge." + field +
                      ", give this scene the same or fill it with DROP");
  };
  if (wanted.bucket().SerializeAsString() != source.bucket().SerializeAsString())
    return differs("bucket");
  if (wanted.particles().SerializeAsString() != source.particles().SerializeAsString())
    return differs("particles");
  return Done{};
}

}  // namespace

Status take_stored_filling(JobStore& store, NewJob& job) {
  v1::Scene scene;
  scene.ParseFromString(job.resolved_bytes);
  const std::string& name = scene.discharge().stored_filling();
  const auto id = job_id_from(name);
  if (!id) return refuse(ErrorCode::invalid_argument, "= \"" + name + "\" is no job, e.g. jobs/17");
  const auto source = store.find_job(*id);
  if (!source) return refuse(ErrorCode::not_found, name + " does not exist");
  if (source->filling_key.empty())
    return refuse(ErrorCode::invalid_argument, name + " has no filling to share");
  v1::Scene filled;
  filled.ParseFromString(source->resolved_bytes);
  if (Status fits = check_fits(scene.discharge(), filled.discharge(), name); !fits) return fits;
  const std::string key_now = filling_key(filled);  // of a STORED job: known by its source only
  if (!key_now.empty() && key_now != source->filling_key)
    return refuse(ErrorCode::failed_precondition,
                  name + " was filled by another engine version, run it again");
  if (!store.find_filling(source->filling_key))
    return refuse(ErrorCode::failed_precondition,
                  name + " is " + std::string(to_string(source->state)) +
                      " and has not stored its filling, wait until it has filled its bucket");
  job.filling_key = source->filling_key;
  scene.mutable_discharge()->set_stored_filling(source->filling_key);
  job.key = job_key(scene);
  return Done{};
}

}  // namespace granary::server
