#include "server/store/scene_field.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <vector>

#include "granary/v1/scene.pb.h"

namespace granary::server {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

struct Step {
  const FieldDescriptor* field;
  int index;  // of a repeated field; 0 otherwise
};
using Path = std::vector<Step>;

// "chute.particles[0].diameter_m"; empty when there is no such field.
Path find_path(std::string_view text) {
  Path path;
  const Descriptor* type = v1::Scene::descriptor();
  while (!text.empty() && type != nullptr) {
    const std::size_t end = std::min(text.find('.'), text.size());
    std::string_view part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    int index = 0;
    if (const auto open = part.find('['); open != std::string_view::npos) {
      std::from_chars(part.data() + open + 1, part.data() + part.size(), index);
      part = part.substr(0, open);
    }
    const FieldDescriptor* field = type->FindFieldByName(std::string(part));
    if (field == nullptr) return {};
    path.push_back({field, index});
    type = field->message_type();
  }
  return type == nullptr ? path : Path{};
}

bool read_scalar(CodedInputStream& in, const FieldDescriptor& field, SceneScalar& found) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    std::uint64_t bits = 0;
    if (!in.ReadLittleEndian64(&bits)) return false;
    found = std::bit_cast<double>(bits);
    return true;
  }
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    std::uint32_t size = 0;
    auto& text = found.emplace<std::string>();
    return in.ReadVarint32(&size) && in.ReadString(&text, static_cast<int>(size));
  }
  std::uint64_t value = 0;
  if (!in.ReadVarint64(&value)) return false;
  found = static_cast<std::int64_t>(value);
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_ENUM) return true;
  const auto* name = field.enum_type()->FindValueByNumber(static_cast<int>(value));
  found = name ? name->name() : std::to_string(value);
  return true;
}

// The last occurrence of a singular field wins, as in protobuf's own parser.
bool walk(CodedInputStream& in, const Path& path, std::size_t depth, SceneScalar& found) {
  const Step& step = path[depth];
  int seen = 0;
  while (const std::uint32_t tag = in.ReadTag()) {
    if (WireFormatLite::GetTagFieldNumber(tag) != step.field->number() ||
        (step.field->is_repeated() && seen++ != step.index)) {
      if (!WireFormatLite::SkipField(&in, tag)) return false;
      continue;
    }
    if (depth + 1 == path.size()) {
      if (!read_scalar(in, *step.field, found)) return false;
      continue;
    }
    std::uint32_t size = 0;
    if (!in.ReadVarint32(&size)) return false;
    const auto limit = in.PushLimit(static_cast<int>(size));
    if (!walk(in, path, depth + 1, found)) return false;
    in.PopLimit(limit);
  }
  return true;
}

}  // namespace

struct SceneField::Steps {
  Path path;
};

SceneField::SceneField(std::string_view path) : steps_(new Steps{find_path(path)}) {}
SceneField::SceneField(SceneField&&) noexcept = default;
SceneField::~SceneField() = default;

SceneScalar SceneField::in(const void* scene, int size_bytes) const {
  SceneScalar found;
  if (steps_->path.empty() || scene == nullptr) return found;
  CodedInputStream in(static_cast<const std::uint8_t*>(scene), size_bytes);
  if (!walk(in, steps_->path, 0, found)) return {};
  return found;
}

}  // namespace granary::server
