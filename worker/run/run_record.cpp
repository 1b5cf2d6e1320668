#include "worker/run/run_record.h"

#include <string>
#include <type_traits>

namespace granary::run {
namespace {

using storage::ByteReader;
using storage::Bytes;
using storage::ByteWriter;

template <typename T>
void put_record(ByteWriter& out, const T& record) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.put_bytes(std::as_bytes(std::span(&record, 1)));
}
template <typename T>
T get_record(ByteReader& in) {
  static_assert(std::is_trivially_copyable_v<T>);
  T record;
  std::memcpy(&record, in.take(sizeof record).data(), sizeof record);
  return record;
}

// Lists are a count and their elements.
template <typename T, typename Put>
void put_list(ByteWriter& out, const std::vector<T>& list, Put&& put) {
  out.put(static_cast<std::uint32_t>(list.size()));
  for (const T& element : list) put(element);
}
template <typename Get>
auto get_list(ByteReader& in, Get&& get) {
  std::vector<decltype(get())> list;
  for (auto left = in.get<std::uint32_t>(); left > 0; --left) list.push_back(get());
  return list;
}

void put_optional(ByteWriter& out, const std::optional<double>& value) {
  out.put(static_cast<std::uint8_t>(value.has_value()));
  out.put(value.value_or(0));
}
std::optional<double> get_optional(ByteReader& in) {
  const bool known = in.get<std::uint8_t>() != 0;
  const double value = in.get<double>();
  return known ? std::optional(value) : std::nullopt;
}

void put_value(ByteWriter& out, const core::ObservedValue& value) {
  out.put_text(value.name);
  out.put_text(value.unit);
  put_optional(out, value.value);
  put_optional(out, value.error);
  out.put_text(value.error_basis);
}
core::ObservedValue get_value(ByteReader& in) {
  core::ObservedValue value;
  value.name = in.get_text();
  value.unit = in.get_text();
  value.value = get_optional(in);
  value.error = get_optional(in);
  value.error_basis = in.get_text();
  return value;
}

void put_tables(Bytes& out, const std::vector<core::Table>& tables) {
  ByteWriter writer(out);
  put_list(writer, tables, [&](const core::Table& table) {
    writer.put_text(table.name);
    storage::encode_state(out, core::State{table.columns});
  });
}
std::vector<core::Table> get_tables(ByteReader& in) {
  return get_list(in, [&] {
    core::Table table;
    table.name = in.get_text();
    table.columns = storage::decode_columns(in);
    return table;
  });
}

void put_first(Bytes& out, const core::Observation& first) {
  put_tables(out, first.series);
  put_tables(out, first.fields);
  ByteWriter writer(out);
  put_list(writer, first.warnings, [&](const std::string& text) { writer.put_text(text); });
  put_list(writer, first.effect_evaluations, [&](const auto& effect) {
    writer.put_text(effect.first);
    writer.put(effect.second);
  });
}
core::Observation get_first(ByteReader& in) {
  core::Observation first;
  first.series = get_tables(in);
  first.fields = get_tables(in);
  first.warnings = get_list(in, [&] { return in.get_text(); });
  first.effect_evaluations = get_list(in, [&] {
    std::string name = in.get_text();
    return std::pair(std::move(name), in.get<std::uint64_t>());
  });
  return first;
}

void put_replicate(ByteWriter& out, const FinishedReplicate& replicate) {
  out.put(replicate.seed);
  out.put_text(replicate.state_hash);
  put_record(out, replicate.ledger);
  put_list(out, replicate.values, [&](const core::ObservedValue& value) { put_value(out, value); });
}
FinishedReplicate get_replicate(ByteReader& in) {
  FinishedReplicate replicate;
  replicate.seed = in.get<std::uint64_t>();
  replicate.state_hash = in.get_text();
  replicate.ledger = get_record<core::EnergyLedger>(in);
  replicate.values = get_list(in, [&] { return get_value(in); });
  return replicate;
}

}  // namespace

Bytes encode(const RunRecord& record) {
  Bytes bytes;
  ByteWriter out(bytes);
  put_record(out, record.costs);
  put_record(out, record.frames);
  put_record(out, record.mark);
  put_list(out, record.recoveries, [&](const Recovery& recovery) { put_record(out, recovery); });
  put_list(out, record.notes, [&](const RecoveryNote& note) {
    out.put_text(note.path);
    out.put(note.value);
    out.put_text(note.evidence);
  });
  put_first(bytes, record.first);
  put_list(out, record.finished,
           [&](const FinishedReplicate& replicate) { put_replicate(out, replicate); });
  return bytes;
}

RunRecord decode_record(const Bytes& bytes) {
  ByteReader in(bytes);
  RunRecord record;
  record.costs = get_record<RunCosts>(in);
  record.frames = get_record<FrameSchedule::State>(in);
  record.mark = get_record<Mark>(in);
  record.recoveries = get_list(in, [&] { return get_record<Recovery>(in); });
  record.notes = get_list(in, [&] {
    std::string path = in.get_text();
    const double value = in.get<double>();
    return RecoveryNote{std::move(path), value, in.get_text()};
  });
  record.first = get_first(in);
  record.finished = get_list(in, [&] { return get_replicate(in); });
  return record;
}

}  // namespace granary::run
