#include "proto/contract/scene_text.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <vector>

#include "proto/contract/field_path.h"
#include "proto/contract/rule_text.h"
#include "proto/contract/scene_rules.h"

namespace granary {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;
using Json = nlohmann::json;

std::string at(std::string_view file, int line) {
  return std::string(file) + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
}

Error invalid(std::string_view file, int line, const std::string& path, const std::string& what) {
  return {ErrorCode::invalid_argument, at(file, line) + (path.empty() ? "" : path + ": ") + what,
          path};
}

// ------------------------------------------------------------------------------------ text format

struct FirstError : google::protobuf::io::ErrorCollector {
  int line = -1;
  int column = 0;
  std::string message;
  void AddError(int at_line, google::protobuf::io::ColumnNumber at_column,
                const std::string& what) override {
    if (line >= 0) return;  // one line for the user: the first cause
    line = at_line;
    column = at_column;
    message = what;
  }
};

// The groups open at a position of the text, e.g. "discharge.particles": the parser's messages know
// only the type. Comments and strings are skipped.
std::string open_groups(std::string_view text, int line, int column) {
  std::vector<std::string> groups;
  std::string word;
  int at_line = 0, at_column = 0;
  char quote = 0;
  bool comment = false;
  for (const char c : text) {
    if (at_line > line || (at_line == line && at_column >= column)) break;
    if (c == '\n') {
      ++at_line, at_column = 0, comment = false;
      continue;
    }
    ++at_column;
    if (comment) continue;
    if (quote)
      quote = c == quote ? 0 : quote;
    else if (c == '#')
      comment = true;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
      if (!word.empty() && word.back() == ' ') word.clear();
      word += c;
    } else if (c == '{' || c == '<')
      groups.push_back(std::exchange(word, ""));
    else if ((c == '}' || c == '>') && !groups.empty())
      groups.pop_back(), word.clear();
    else if ((c == ' ' || c == ':') && !word.empty() && word.back() != ' ')
      word += ' ';
  }
  std::string path;
  for (std::string group : groups) {
    if (!group.empty() && group.back() == ' ') group.pop_back();
    path += (path.empty() ? "" : ".") + group;
  }
  return path;
}

// Turns the parser's words into ours: unknown names get the nearest known one.
Error text_error(std::string_view text, std::string_view file, const FirstError& first) {
  const std::string groups = open_groups(text, first.line, first.column);
  static const std::regex unknown("Message type \"([^\"]+)\" has no field named \"([^\"]+)\".*");
  std::smatch match;
  if (std::regex_match(first.message, match, unknown)) {
    const Descriptor* type =
        google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(match[1]);
    const std::string path = groups.empty() ? match[2].str() : groups + "." + match[2].str();
    return invalid(file, first.line + 1, path,
                   type ? unknown_field_text(*type, match[2].str()) : first.message);
  }
  std::string message = first.message;
  while (!message.empty() && message.back() == '.') message.pop_back();
  return invalid(file, first.line + 1, groups, message);
}

void collect_lines(const Message& message, const TextFormat::ParseInfoTree& tree,
                   const std::string& prefix, std::map<std::string, int>* lines) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? message.GetReflection()->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const int index = field->is_repeated() ? i : -1;
      std::string path = prefix + field->name();
      if (index >= 0) path += "[" + std::to_string(i) + "]";
      (*lines)[path] = tree.GetLocation(field, index).line + 1;
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
      const Message& child = index < 0
                                 ? message.GetReflection()->GetMessage(message, field)
                                 : message.GetReflection()->GetRepeatedMessage(message, field, i);
      if (const auto* subtree = tree.GetTreeForNested(field, index))
        collect_lines(child, *subtree, path + ".", lines);
    }
  }
}

// Length of the character at the start of `text`, 0 when these bytes are not UTF-8.
std::size_t utf8_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  const bool overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
  const bool surrogate = first == 0xED && byte(1) > 0x9F;
  return overlong || surrogate || (first == 0xF4 && byte(1) > 0x8F) ? 0 : length;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_character(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

// Path of a text that is not UTF-8, which no message may carry; escapes make it from harmless bytes.
std::string path_of_bad_text(const Message& message, const std::string& prefix) {
  std::vector<const FieldDescriptor*> fields;
  const auto& reflection = *message.GetReflection();
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string path = prefix + field->name() + (field->is_repeated() ? "[" + std::to_string(i) + "]" : "");
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        const std::string found = path_of_bad_text(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                                                        : reflection.GetMessage(message, field),
                                                   path + ".");
        if (!found.empty()) return found;
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING &&
                 !is_utf8(field->is_repeated() ? reflection.GetRepeatedString(message, field, i)
                                               : reflection.GetString(message, field))) {
        return path;
      }
    }
  }
  return {};
}

using Lines = std::map<std::string, int>;

Result<Lines> parse_text(std::string_view text, std::string_view file, Message& message) {
  Lines lines;
  FirstError first;
  TextFormat::ParseInfoTree tree;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&first);
  parser.WriteLocationsTo(&tree);
  parser.SetRecursionLimit(32);
  if (!parser.ParseFromString(std::string(text), &message)) return text_error(text, file, first);
  collect_lines(message, tree, "", &lines);
  return lines;
}

// ------------------------------------------------------------------------------------------- JSON

int line_of_offset(std::string_view text, std::size_t offset) {
  return 1 + static_cast<int>(
                 std::count(text.begin(), text.begin() + std::min(offset, text.size()), '\n'));
}

// JSON carries no positions: the line where the key stands first is the best that can be told.
int line_of_key(std::string_view text, std::string_view key) {
  const std::size_t offset = text.find("\"" + std::string(key) + "\"");
  return offset == std::string_view::npos ? 0 : line_of_offset(text, offset);
}

class JsonReader {
 public:
  JsonReader(std::string_view text, std::string_view file) : text_(text), file_(file) {}

  Status read(const Json& object, Message& message, const std::string& prefix) {
    if (!object.is_object()) return fail(prefix, "", "must be an object {...}");
    for (const auto& [key, value] : object.items()) {
      const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(key);
      if (!field) field = message.GetDescriptor()->FindFieldByCamelcaseName(key);
      if (!field) return fail(prefix + key, key, unknown_field_text(*message.GetDescriptor(), key));
      const std::string path = prefix + field->name();
      lines[path] = line_of_key(text_, key);
      if (value.is_null()) continue;
      if (Status status = field->is_repeated() ? read_list(value, message, *field, key, path)
                                               : read_one(value, message, *field, key, path, path);
          !status)
        return status;
    }
    return Done{};
  }

  std::map<std::string, int> lines;

 private:
  Status read_list(const Json& list, Message& message, const FieldDescriptor& field,
                   const std::string& key, const std::string& path) {
    if (!list.is_array()) return fail(path, key, "must be a list [...]");
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string element = path + "[" + std::to_string(i) + "]";
      if (Status status = read_one(list[i], message, field, key, element, element); !status)
        return status;
    }
    return Done{};
  }

  Status read_one(const Json& value, Message& message, const FieldDescriptor& field,
                  const std::string& key, const std::string& path, const std::string& element) {
    lines[element] = line_of_key(text_, key);
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      Message* child = field.is_repeated()
                           ? message.GetReflection()->AddMessage(&message, &field)
                           : message.GetReflection()->MutableMessage(&message, &field);
      return read(value, *child, path + ".");
    }
    if (value.is_object() || value.is_array()) return fail(path, key, "must be a single value");
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    const std::string own = path.substr(path.rfind('.') + 1);
    if (Status status = set_field(message, own, text); !status) {
      const std::string& what = status.error().message;
      return fail(path, key, what.substr(what.find(": ") + 2));
    }
    return Done{};
  }

  Error fail(std::string path, const std::string& key, const std::string& what) const {
    if (!path.empty() && path.back() == '.') path.pop_back();
    return invalid(file_, key.empty() ? 0 : line_of_key(text_, key), path, what);
  }

  std::string_view text_;
  std::string_view file_;
};

Result<Lines> parse_json(std::string_view text, std::string_view file, Message& message) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    return invalid(file, line_of_offset(text, error.byte), "", "not valid JSON here");
  } catch (const Json::out_of_range&) {
    return invalid(file, 0, "", "a number in it is beyond the range of a double (1.8e308)");
  }
  JsonReader reader(text, file);
  if (Status status = reader.read(json, message, ""); !status) return status.error();
  return std::move(reader.lines);
}

}  // namespace

Result<ParsedScene> parse_scene(std::string_view text, std::string_view file_name) {
  ParsedScene parsed;
  auto lines = parse_message(text, file_name, parsed.scene);
  if (!lines) return lines.error();
  parsed.line_of = std::move(*lines);
  return parsed;
}

Result<Lines> parse_message(std::string_view text, std::string_view file_name, Message& message) {
  if (text.size() > kMaxSceneBytes)
    return invalid(file_name, 0, "", "is larger than the 16 MiB a scene may have");
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return invalid(file_name, 0, "", "is empty: no scene in it");
  auto lines = text[first] == '{' ? parse_json(text, file_name, message)
                                  : parse_text(text, file_name, message);
  if (!lines) return lines;
  if (const std::string path = path_of_bad_text(message, ""); !path.empty())
    return invalid(file_name, (*lines)[path], path, "is not valid UTF-8 text");
  return lines;
}

namespace {

Result<v1::Scene> load(std::string_view text, std::string_view file_name,
                       std::span<const FieldSetting> settings) {
  auto parsed = parse_scene(text, file_name);
  if (!parsed) return parsed.error();
  for (const auto& [path, value] : settings) {
    if (Status status = set_field(parsed->scene, path, value); !status)
      return Error{status.error().code, "--set " + status.error().message,
                   status.error().field_path};
    parsed->line_of.erase(path);
  }
  if (const std::string path = path_of_bad_text(parsed->scene, ""); !path.empty())  // by --set
    return invalid(file_name, 0, path, "is not valid UTF-8 text");
  if (Status status = validate_scene(parsed->scene); !status) {
    const Error& error = status.error();
    const auto line = parsed->line_of.find(error.field_path);
    const std::string where =
        line != parsed->line_of.end() ? at(file_name, line->second) : at(file_name, 0);
    return Error{error.code, where + error.message, error.field_path};
  }
  return parsed->scene;
}

}  // namespace

Result<v1::Scene> load_scene(std::string_view text, std::string_view file_name,
                             std::span<const FieldSetting> settings) {
  auto scene = load(text, file_name, settings);
  if (scene) return scene;
  const Error& error = scene.error();
  return Error{error.code, one_line(error.message), error.field_path};
}

std::string scene_to_text(const v1::Scene& scene) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(scene, &text);
  return text;
}

std::string scene_to_json(const v1::Scene& scene) {
  std::string text;
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  (void)google::protobuf::util::MessageToJsonString(scene, &text, options);
  return text;
}

}  // namespace granary
