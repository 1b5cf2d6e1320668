// Columns as bytes, little-endian, unaligned: the one encoding of segments and checkpoints.
//   columns := u32 count, column * count
//   column  := u32 length, name, u32 length, unit, u8 element type (core::ElementType), u64 rows,
//              u64 width, rows * width elements
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "worker/core/column.h"

namespace granary::storage {

using Bytes = std::vector<std::byte>;

class ByteWriter {
 public:
  explicit ByteWriter(Bytes& bytes) : bytes_(bytes) {}
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    put_bytes({reinterpret_cast<const std::byte*>(&value), sizeof value});
  }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    put_bytes(std::as_bytes(std::span(text)));
  }
  void put_bytes(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + bytes.size());
    std::memcpy(bytes_.data() + at, bytes.data(), bytes.size());
  }

 private:
  Bytes& bytes_;
};

// Every getter throws StorageError(damaged) rather than read past the end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <typename T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string get_text();
  std::span<const std::byte> take(std::uint64_t byte_count);
  Bytes rest() const { return {bytes_.begin(), bytes_.end()}; }

 private:
  std::span<const std::byte> bytes_;
};

void encode_columns(Bytes& out, std::span<const core::ColumnView> columns);
void encode_state(Bytes& out, const core::State& state);
std::vector<core::Column> decode_columns(ByteReader& in);

}  // namespace granary::storage
