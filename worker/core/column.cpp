#include "worker/core/column.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>

namespace granary::core {

std::size_t element_bytes(ElementType type) {
  switch (type) {
    case ElementType::f32:
    case ElementType::i32:
    case ElementType::u32: return 4;
    case ElementType::f64:
    case ElementType::i64:
    case ElementType::u64: return 8;
    case ElementType::u8: return 1;
  }
  throw std::logic_error("unknown element type");
}

ColumnView view_of(const Column& column) {
  return {column.name, column.unit, column.type, column.rows, column.width, column.bytes.data()};
}

const Column* State::find(std::string_view name) const {
  for (const Column& column : columns)
    if (column.name == name) return &column;
  return nullptr;
}

const Column& State::require(std::string_view name) const {
  if (const Column* column = find(name)) return *column;
  throw std::runtime_error("state: no column " + std::string(name));
}

std::string hash_columns(std::span<const ColumnView> columns) {
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  for (const ColumnView& column : columns) {
    const std::uint64_t shape[3] = {static_cast<std::uint64_t>(column.type), column.rows, column.width};
    XXH3_128bits_update(&state, column.name.data(), column.name.size());
    XXH3_128bits_update(&state, shape, sizeof shape);
    if (column.size_bytes() > 0) XXH3_128bits_update(&state, column.data, column.size_bytes());
  }
  const XXH128_hash_t hash = XXH3_128bits_digest(&state);
  char text[33];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text;
}

}  // namespace granary::core
