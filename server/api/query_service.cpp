#include "server/api/query_service.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "server/api/outgoing_queue.h"
#include "server/store/query_door.h"

namespace granary::server {
namespace {

constexpr int kRowsPerMessage = 256;
constexpr std::size_t kBytesPerMessage = 256 << 10;
constexpr int kMessagesAhead = 4;  // a slow reader stops the query, not the memory
constexpr std::chrono::seconds kSlowestReader{60};

using Queue = OutgoingQueue<v1::QueryRows>;

// Shared by the reactor, which gRPC deletes, and the query thread.
class QueryStream : public RowSink {
 public:
  explicit QueryStream(Queue::Reactor reactor) : queue_(std::move(reactor)) {}

  void columns(const std::vector<std::string>& names) override {
    for (const std::string& name : names) batch_.add_columns(name);
    (void)send();
  }

  bool row(std::vector<Cell> cells) override {
    v1::QueryRow& row = *batch_.add_rows();
    for (Cell& cell : cells) add(std::move(cell), *row.add_cells());
    bytes_ += row.ByteSizeLong();
    return batch_.rows_size() < kRowsPerMessage && bytes_ < kBytesPerMessage ? !cancelled : send();
  }

  void finish(const Status& status) {
    if (batch_.rows_size() > 0) (void)send();
    queue_.finish(to_grpc(status));
  }

  void on_write_done(bool ok) {
    {
      std::lock_guard lock(mutex_);
      --ahead_;
      if (!ok) cancelled = true;
      room_.notify_all();
    }
    queue_.on_write_done(ok);
  }
  void on_cancel() {
    {
      std::lock_guard lock(mutex_);
      cancelled = true;
      room_.notify_all();
    }
    queue_.abort(grpc::Status::CANCELLED);
  }

  std::atomic<bool> cancelled = false;

 private:
  static void add(Cell cell, v1::QueryCell& out) {
    if (const auto* integer = std::get_if<std::int64_t>(&cell)) out.set_integer(*integer);
    if (const auto* real = std::get_if<double>(&cell)) out.set_real(*real);
    if (auto* text = std::get_if<std::string>(&cell)) out.set_text(std::move(*text));
    if (auto* blob = std::get_if<Blob>(&cell))
      out.set_blob(std::string(blob->begin(), blob->end()));
  }

  bool send() {
    {
      std::unique_lock lock(mutex_);
      const bool room = room_.wait_for(lock, kSlowestReader,
                                       [this] { return cancelled || ahead_ < kMessagesAhead; });
      if (cancelled || !room) return false;
      ++ahead_;
    }
    queue_.push(std::exchange(batch_, {}));
    bytes_ = 0;
    return true;
  }

  Queue queue_;
  v1::QueryRows batch_;
  std::size_t bytes_ = 0;
  std::mutex mutex_;
  std::condition_variable room_;
  int ahead_ = 0;
};

class QueryReactor : public grpc::ServerWriteReactor<v1::QueryRows> {
 public:
  QueryReactor()
      : stream(std::make_shared<QueryStream>(
            Queue::Reactor{[this](const v1::QueryRows* rows) { StartWrite(rows); },
                           [this](grpc::Status status) { Finish(std::move(status)); }})) {}

  void OnWriteDone(bool ok) override { stream->on_write_done(ok); }
  void OnCancel() override { stream->on_cancel(); }
  void OnDone() override { delete this; }

  std::shared_ptr<QueryStream> stream;
};

QueryLimits limits_of(const v1::QueryRequest& request) {
  QueryLimits limits;
  if (request.time_limit_s() > 0) limits.time_s = std::min(request.time_limit_s(), kMaxQueryTime_s);
  if (request.row_limit() > 0)
    limits.rows = std::min<std::uint64_t>(request.row_limit(), kMaxQueryRows);
  return limits;
}

}  // namespace

grpc::ServerWriteReactor<v1::QueryRows>* QueryService::Run(grpc::CallbackServerContext*,
                                                           const v1::QueryRequest* request) {
  backend_.touch();
  auto* reactor = new QueryReactor;
  const auto stream = reactor->stream;
  const bool accepted =
      threads_.post([this, stream, sql = request->sql(), limits = limits_of(*request)] {
        stream->finish(run_query(database_, sql, limits, *stream, stream->cancelled));
      });
  if (!accepted)
    stream->finish(Error{ErrorCode::resource_exhausted,
                         "too many queries are waiting, try again in a few seconds", ""});
  return reactor;
}

grpc::ServerUnaryReactor* QueryService::GetSchema(grpc::CallbackServerContext* context,
                                                  const v1::GetSchemaRequest*,
                                                  v1::GetSchemaResponse* response) {
  backend_.touch();
  auto* reactor = context->DefaultReactor();
  try {
    for (const ViewText& view : list_views(database_)) {
      v1::View& message = *response->add_views();
      message.set_name(view.name);
      message.set_meaning(view.meaning);
      for (const ViewColumnText& column : view.columns) {
        message.add_columns()->set_name(column.name);
        message.mutable_columns()->rbegin()->set_meaning(column.meaning);
      }
    }
    reactor->Finish(grpc::Status::OK);
  } catch (const std::exception& error) {
    reactor->Finish({grpc::StatusCode::INTERNAL, error.what()});
  }
  return reactor;
}

}  // namespace granary::server
