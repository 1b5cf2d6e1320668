#include "worker/run/run_storage.h"

#include "proto/contract/scene_text.h"
#include "worker/storage/result_writer.h"
#include "worker/storage/storage_error.h"

namespace granary::run {
namespace {

// Besides the physics, the output settings decide which frames a run stores.
storage::RunIdentity identity_of(const TaskSpec& spec) {
  v1::Scene output_only;
  *output_only.mutable_output() = spec.scene.output();
  return {spec.scene_key + '\n' + spec.variant + scene_to_text(output_only), spec.engine_version,
          spec.vector_path};
}

storage::RunIdentity filling_identity(const TaskSpec& spec) {
  return {"filling " + spec.filling_key, spec.engine_version, spec.vector_path};
}

// The state at the last mark lies in the same file; engines do not know this prefix.
const std::string kMarkPrefix = "mark/";

void put_mark(core::State& engine, const core::State& mark) {
  for (const core::Column& column : mark.columns) {
    engine.put(column);
    engine.columns.back().name = kMarkPrefix + column.name;
  }
}

// A checkpoint taken at a mark holds it once.
core::State take_mark(core::State& engine) {
  core::State mark;
  for (core::Column& column : engine.columns)
    if (column.name.starts_with(kMarkPrefix)) {
      column.name.erase(0, kMarkPrefix.size());
      mark.put(std::move(column));
      column.name.clear();
    }
  if (mark.columns.empty()) return engine;
  std::erase_if(engine.columns, [](const core::Column& column) { return column.name.empty(); });
  return mark;
}

}  // namespace

RunStorage::RunStorage(storage::FileSystem& files, const TaskSpec& spec, Log log)
    : files_(files),
      active_(!spec.result_path.empty()),
      result_path_(spec.result_path),
      directory_(spec.work_directory),
      identity_(identity_of(spec)),
      frames_(files, directory_, identity_, scene_to_text(spec.scene)),
      log_(std::move(log)) {
  if (active_) files_.create_directory(directory_);
}

std::optional<RunStorage::Resumed> RunStorage::resume() {
  if (!active_) return std::nullopt;
  Resumed resumed;
  auto checkpoint = storage::load_checkpoint(
      files_, directory_, identity_,
      [&](const storage::Checkpoint& candidate) {
        resumed.record = decode_record(candidate.run);
        frames_.restore(candidate.segments);
      },
      [&](const std::string& reason) { log_("checkpoint passed over: " + reason); });
  if (!checkpoint) {
    start_over();
    return std::nullopt;
  }
  resumed.engine = std::move(checkpoint->engine);
  resumed.mark = take_mark(resumed.engine);
  return resumed;
}

void RunStorage::start_over() {
  if (!active_) return;
  storage::remove_checkpoints(files_, directory_);
  frames_.clear();
}

void RunStorage::append_frame(const storage::FrameView& frame) {
  if (active_) frames_.append(frame);
}

void RunStorage::drop_frames_from(std::uint64_t frame_index) {
  if (active_) frames_.drop_from(frame_index);
}

void RunStorage::save(const RunRecord& record, core::State engine, const core::State* mark) {
  if (!active_) return;
  if (mark != nullptr) put_mark(engine, *mark);
  const auto& segments = frames_.seal();
  try {
    storage::save_checkpoint(files_, directory_,
                             {identity_, segments, encode(record), std::move(engine)});
  } catch (const storage::StorageError& error) {
    log_(std::string("checkpoint not written, going on: ") + error.what());
  }
}

void RunStorage::publish(const storage::ResultContent& content) {
  storage::ResultWriter writer(files_, result_path_);
  frames_.for_each([&](const storage::Frame& frame) { writer.add_frame(frame); });
  writer.add_content(content);
  writer.commit();
}

std::optional<StoredFilling> load_filling(storage::FileSystem& files, const TaskSpec& spec,
                                          const Log& log) {
  if (spec.filling_key.empty() || spec.filling_input.empty()) return std::nullopt;
  if (!files.exists(spec.filling_input)) return std::nullopt;
  try {
    auto file = storage::read_checkpoint_file(files, spec.filling_input, filling_identity(spec));
    storage::ByteReader seconds(file.run);
    return StoredFilling{std::move(file.engine), seconds.get<double>()};
  } catch (const storage::StorageError& error) {
    log(std::string("stored filling not used: ") + error.what());
    return std::nullopt;
  }
}

void save_filling(storage::FileSystem& files, const TaskSpec& spec, const StoredFilling& filling) {
  storage::Checkpoint file;
  file.identity = filling_identity(spec);
  file.engine = filling.state;
  storage::ByteWriter(file.run).put(filling.cpu_s);
  storage::write_checkpoint_file(files, spec.filling_output, file);
}

}  // namespace granary::run
