#include "client/session/fetch.h"

#include <fstream>

#include "client/session/backoff.h"
#include "client/session/file_checksum.h"
#include "client/session/part_file.h"

namespace granary::session {
namespace {

namespace fs = std::filesystem;

constexpr BackoffLimits kResume{.first_s = 0.1, .longest_s = 5, .patience_s = 60};

class Fetch {
 public:
  Fetch(Session& session, const FetchRequest& request, const FetchProgress& progress,
        Interrupt& interrupt)
      : session_(session), request_(request), progress_(progress), interrupt_(interrupt) {}

  Result<Fetched> run();

 private:
  Result<bool> already_there();
  Status receive_all(PartFile& part);
  Status take(PartFile& part, const v1::DownloadChunk& chunk);
  Status publish(PartFile& part);

  Session& session_;
  const FetchRequest& request_;
  const FetchProgress& progress_;
  Interrupt& interrupt_;
  v1::Artifact artifact_;
  Backoff backoff_{kResume};
};

Result<Fetched> Fetch::run() {
  auto job = session_.get(request_.job);
  if (!job) return job.error();
  artifact_ = job->result();
  if (artifact_.sha256().empty())
    return Error{ErrorCode::failed_precondition, request_.job + " has no result file", ""};
  const Fetched fetched{artifact_.sha256(), artifact_.size_bytes(), false};
  auto there = already_there();
  if (!there) return there.error();
  if (*there) return Fetched{fetched.sha256, fetched.size_bytes, true};
  auto part = PartFile::open(with_suffix(request_.file, ".part"));
  if (!part) return part.error();
  const bool resumed = part->size_bytes() > 0;
  if (auto received = receive_all(*part); !received) return received.error();
  auto sum = sha256_of_file(part->path());
  if (sum && *sum != artifact_.sha256() && resumed) {
    // The part was of another result: once more from the start.
    if (auto emptied = part->empty(); !emptied) return emptied.error();
    if (auto received = receive_all(*part); !received) return received.error();
    sum = sha256_of_file(part->path());
  }
  if (!sum) return sum.error();
  if (*sum != artifact_.sha256())
    return Error{ErrorCode::data_loss,
                 part->path().string() + ": content has SHA-256 " + *sum + ", recorded is " +
                     artifact_.sha256(),
                 ""};
  if (auto published = publish(*part); !published) return published.error();
  return fetched;
}

Result<bool> Fetch::already_there() {
  std::error_code failure;
  if (!fs::exists(request_.file, failure)) return false;
  auto sum = sha256_of_file(request_.file);
  if (!sum) return sum.error();
  if (*sum == artifact_.sha256()) return true;
  if (request_.overwrite) return false;
  return Error{ErrorCode::failed_precondition,
               request_.file.string() + " exists with other content; --force replaces it", ""};
}

Status Fetch::receive_all(PartFile& part) {
  if (part.size_bytes() > artifact_.size_bytes())
    if (auto emptied = part.empty(); !emptied) return emptied.error();
  while (part.size_bytes() < artifact_.size_bytes()) {
    const std::uint64_t before_bytes = part.size_bytes();
    const auto passed = session_.download(
        request_.job, before_bytes,
        [&](const v1::DownloadChunk& chunk) -> Status { return take(part, chunk); });
    if (!passed && passed.error().code != ErrorCode::unavailable) return passed.error();
    if (part.size_bytes() > before_bytes) backoff_.reset();
    if (part.size_bytes() >= artifact_.size_bytes()) break;
    const auto delay_s = backoff_.next_delay_s(0.5);
    if (!delay_s)
      return passed ? Error{ErrorCode::data_loss, "the server sends no more of the file", ""}
                    : passed.error();
    if (interrupt_.wait_for_s(*delay_s)) break;
    if (auto renewed = session_.reconnect(); !renewed) return renewed.error();
  }
  if (interrupt_.requested())
    return Error{ErrorCode::cancelled, "interrupted; the same command continues", ""};
  return Done{};
}

Status Fetch::take(PartFile& part, const v1::DownloadChunk& chunk) {
  if (interrupt_.requested())
    return Error{ErrorCode::unavailable, "interrupted", ""};  // ends the pass; receive_all sees why
  const std::uint64_t have_bytes = part.size_bytes();
  if (chunk.offset_bytes() != have_bytes)
    return Error{ErrorCode::data_loss,
                 "the server sent offset " + std::to_string(chunk.offset_bytes()) + " instead of " +
                     std::to_string(have_bytes),
                 ""};
  if (auto written = part.write_at(have_bytes, chunk.data()); !written) return written;
  progress_(have_bytes + chunk.data().size(), artifact_.size_bytes());
  return Done{};
}

Status Fetch::publish(PartFile& part) {
  if (auto synced = part.sync(); !synced) return synced;
  std::error_code failure;
  fs::rename(part.path(), request_.file, failure);
  if (failure)
    return Error{ErrorCode::failed_precondition, request_.file.string() + ": " + failure.message(),
                 ""};
  if (!request_.record_checksum) return Done{};
  std::ofstream sums(with_suffix(request_.file, ".sha256"));
  sums << artifact_.sha256() << "  " << request_.file.filename().string() << "\n";
  return Done{};
}

}  // namespace

Result<Fetched> fetch_result(Session& session, const FetchRequest& request,
                             const FetchProgress& progress, Interrupt& interrupt) {
  return Fetch(session, request, progress, interrupt).run();
}

}  // namespace granary::session
