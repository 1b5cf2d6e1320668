#include "worker/storage/column_codec.h"

#include <bit>

#include "worker/storage/storage_error.h"

namespace granary::storage {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

namespace {

constexpr std::uint8_t kElementTypeCount = static_cast<std::uint8_t>(core::ElementType::u8) + 1;

core::Column decode_column(ByteReader& in) {
  core::Column column;
  column.name = in.get_text();
  column.unit = in.get_text();
  const auto type = in.get<std::uint8_t>();
  if (type >= kElementTypeCount)
    throw StorageError(StorageFault::damaged, "column " + column.name + ": unknown element type");
  column.type = static_cast<core::ElementType>(type);
  column.rows = in.get<std::uint64_t>();
  column.width = in.get<std::uint64_t>();
  // A damaged shape must not overflow into a small product.
  std::uint64_t element_count = 0;
  std::uint64_t byte_count = 0;
  if (__builtin_mul_overflow(column.rows, column.width, &element_count) ||
      __builtin_mul_overflow(element_count, core::element_bytes(column.type), &byte_count))
    throw StorageError(StorageFault::damaged, "column " + column.name + ": impossible shape");
  const auto bytes = in.take(byte_count);
  column.bytes.assign(bytes.begin(), bytes.end());
  return column;
}

}  // namespace

std::string ByteReader::get_text() {
  const auto bytes = take(get<std::uint32_t>());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> ByteReader::take(std::uint64_t byte_count) {
  if (byte_count > bytes_.size())
    throw StorageError(StorageFault::damaged, "data ends in the middle of a record");
  const auto taken = bytes_.first(byte_count);
  bytes_ = bytes_.subspan(byte_count);
  return taken;
}

void encode_columns(Bytes& out, std::span<const core::ColumnView> columns) {
  ByteWriter writer(out);
  writer.put(static_cast<std::uint32_t>(columns.size()));
  for (const core::ColumnView& column : columns) {
    writer.put_text(column.name);
    writer.put_text(column.unit);
    writer.put(static_cast<std::uint8_t>(column.type));
    writer.put(static_cast<std::uint64_t>(column.rows));
    writer.put(static_cast<std::uint64_t>(column.width));
    writer.put_bytes({static_cast<const std::byte*>(column.data), column.size_bytes()});
  }
}

void encode_state(Bytes& out, const core::State& state) {
  std::vector<core::ColumnView> views;
  views.reserve(state.columns.size());
  for (const core::Column& column : state.columns) views.push_back(core::view_of(column));
  encode_columns(out, views);
}

std::vector<core::Column> decode_columns(ByteReader& in) {
  const auto count = in.get<std::uint32_t>();
  std::vector<core::Column> columns;
  for (std::uint32_t i = 0; i < count; ++i) columns.push_back(decode_column(in));
  return columns;
}

}  // namespace granary::storage
