#include "worker/storage/result_writer.h"

#include <map>

#include "worker/storage/hdf5_file_writer.h"
#include "worker/storage/storage_error.h"

namespace granary::storage {
namespace {

// numbered("/frames/", 6, 12) = "/frames/000012": names sort like their numbers.
std::string numbered(std::string group, std::size_t digit_count, std::uint64_t number) {
  const std::string digits = std::to_string(number);
  if (digits.size() < digit_count) group.append(digit_count - digits.size(), '0');
  return group.append(digits);
}

void write_values(hdf5::FileWriter& file, const std::string& group,
                  const std::vector<core::ObservedValue>& values) {
  file.create_group(group);
  for (const core::ObservedValue& observed : values) {
    const std::string path = group + "/" + observed.name;
    if (observed.value)
      file.write_scalar(path, observed.unit, *observed.value);
    else
      file.write_unknown(path, observed.unit);
    if (observed.error) file.set_attribute(path, "error", *observed.error);
    file.set_attribute(path, "error_basis", observed.error_basis);
  }
}

void write_tables(hdf5::FileWriter& file, const std::string& group,
                  const std::vector<core::Table>& tables) {
  file.create_group(group);
  for (const core::Table& table : tables) {
    const std::string path = group + "/" + table.name;
    file.create_group(path);
    for (const core::Column& column : table.columns)
      file.write_column(path + "/" + column.name, core::view_of(column));
  }
}

void write_replicates(hdf5::FileWriter& file, const std::vector<ReplicateContent>& replicates) {
  if (replicates.empty()) return;
  file.create_group("/replicates");
  for (std::size_t i = 0; i < replicates.size(); ++i) {
    const std::string group = numbered("/replicates/", 3, i);
    write_values(file, group, replicates[i].values);
    file.set_attribute(group, "seed", replicates[i].seed);
    file.set_attribute(group, "state_hash", replicates[i].state_hash);
  }
}

void write_ledger(hdf5::FileWriter& file, const core::EnergyLedger& ledger) {
  file.create_group("/ledger");
  const std::pair<const char*, double> energies[] = {
      {"kinetic", ledger.kinetic_j},       {"potential", ledger.potential_j},
      {"elastic", ledger.elastic_j},       {"stored_at_start", ledger.stored_at_start_j},
      {"throughput", ledger.throughput_j}, {"remainder", ledger.remainder_j()}};
  for (const auto& [name, energy_j] : energies)
    file.write_scalar(std::string("/ledger/").append(name), "J", energy_j);
  file.write_scalar("/ledger/remainder_ratio", "1", ledger.remainder_ratio());
  file.create_group("/ledger/channels");
  for (std::size_t i = 0; i < core::kEnergyChannelCount; ++i)
    file.write_scalar("/ledger/channels/" + std::string(to_string(core::EnergyChannel(i))), "J",
                      ledger.channels_j[i]);
}

void write_effects(hdf5::FileWriter& file, const ResultContent& content) {
  file.create_group("/effects");
  for (const EffectContent& effect : content.effects) {
    const std::string group = "/effects/" + effect.name;
    file.create_group(group);
    file.set_attribute(group, "on", static_cast<std::uint64_t>(effect.on));
    if (effect.number) file.set_attribute(group, "number", *effect.number);
    if (effect.threshold) file.set_attribute(group, "threshold", *effect.threshold);
    if (effect.omitted_error) file.set_attribute(group, "omitted_error", *effect.omitted_error);
    file.set_attribute(group, "reason", effect.reason);
    file.set_attribute(group, "chosen_by", effect.chosen_by);
    for (const auto& [name, count] : content.observation.effect_evaluations)
      if (name == effect.name) file.set_attribute(group, "evaluations", count);
  }
}

void write_decisions(hdf5::FileWriter& file, const std::vector<DecisionContent>& decisions) {
  const std::pair<const char*, std::string DecisionContent::*> columns[] = {
      {"path", &DecisionContent::path},
      {"value", &DecisionContent::value},
      {"chosen_by", &DecisionContent::chosen_by},
      {"evidence", &DecisionContent::evidence}};
  file.create_group("/provenance/decisions");
  for (const auto& [name, member] : columns) {
    std::vector<std::string> texts;
    for (const DecisionContent& decision : decisions) texts.push_back(decision.*member);
    file.write_texts(std::string("/provenance/decisions/") + name, texts);
  }
}

void write_provenance(hdf5::FileWriter& file, const ProvenanceContent& provenance) {
  const std::string group = "/provenance";
  file.create_group(group);
  const std::pair<const char*, const std::string&> texts[] = {
      {"engine_version", provenance.engine_version},
      {"vector_path", provenance.vector_path},
      {"host", provenance.host},
      {"date_utc", provenance.date_utc},
      {"scene_key", provenance.scene_key},
      {"state_hash", provenance.state_hash}};
  for (const auto& [name, text] : texts) file.set_attribute(group, name, text);
  file.set_attribute(group, "threads", static_cast<std::uint64_t>(provenance.threads));
  for (const auto& [name, value] : provenance.costs) file.set_attribute(group, name.c_str(), value);
  write_decisions(file, provenance.decisions);
  file.write_texts(group + "/warnings", provenance.warnings);
}

}  // namespace

struct ResultWriter::Impl {
  Impl(FileSystem& the_files, Path the_path)
      : files(the_files),
        path(std::move(the_path)),
        temporary(path.string() + ".tmp"),
        file(std::make_unique<hdf5::FileWriter>(temporary)) {
    file->create_group("/frames");
  }

  // Columns that never change (radius, id) are stored once and linked in the other frames. A column
  // that has changed once is not compared again.
  void write_frame_column(hid_t group, const std::string& group_path, const core::Column& column) {
    const auto known = constant_columns.find(column.name);
    if (known != constant_columns.end()) {
      auto& [first, path_of_first] = known->second;
      if (is_same(first, column)) {
        file->link_in(group, path_of_first, column.name);
        return;
      }
      first.bytes.clear();
    } else {
      constant_columns[column.name] = {column, group_path + "/" + column.name};
    }
    file->write_column_in(group, group_path, core::view_of(column));
  }

  static bool is_same(const core::Column& a, const core::Column& b) {
    return !a.bytes.empty() && a.type == b.type && a.rows == b.rows && a.width == b.width &&
           a.unit == b.unit && a.bytes == b.bytes;
  }

  FileSystem& files;
  Path path;
  Path temporary;
  std::unique_ptr<hdf5::FileWriter> file;
  std::map<std::string, std::pair<core::Column, std::string>> constant_columns;  // by name
  bool committed = false;
};

ResultWriter::ResultWriter(FileSystem& files, Path path)
    : impl_(std::make_unique<Impl>(files, std::move(path))) {}

ResultWriter::~ResultWriter() {
  if (impl_->committed) return;
  impl_->file.reset();
  try {
    impl_->files.remove(impl_->temporary);
  } catch (const StorageError&) {
    // The failure that brought us here is already on its way; a leftover .tmp is overwritten next
    // time.
  }
}

void ResultWriter::add_frame(const Frame& frame) {
  const std::string path = numbered("/frames/", 6, frame.index);
  const hdf5::Handle group = impl_->file->open_new_group(path);
  impl_->file->set_attribute_of(group, "time_s", frame.time_s);
  impl_->file->set_attribute_of(group, "phase", frame.phase);
  for (const core::Column& column : frame.columns) impl_->write_frame_column(group, path, column);
}

void ResultWriter::add_content(const ResultContent& content) {
  hdf5::FileWriter& file = *impl_->file;
  file.set_attribute("/", "format", "granary-result");
  file.set_attribute("/", "format_version", static_cast<std::uint64_t>(kResultFormatVersion));
  file.set_attribute("/", "kind", content.kind);
  file.set_attribute("/", "state", content.state);
  file.set_attribute("/", "message", content.message);
  file.write_text("/scene", content.scene_text);
  write_values(file, "/values", content.observation.values);
  write_replicates(file, content.replicates);
  write_tables(file, "/series", content.observation.series);
  write_tables(file, "/fields", content.observation.fields);
  if (content.ledger) write_ledger(file, *content.ledger);
  write_effects(file, content);
  write_provenance(file, content.provenance);
}

void ResultWriter::commit() {
  impl_->file->finish();
  impl_->file.reset();
  impl_->files.sync_file(impl_->temporary);
  impl_->files.rename(impl_->temporary, impl_->path);
  impl_->files.sync_directory(directory_of(impl_->path));
  impl_->committed = true;
}

}  // namespace granary::storage
