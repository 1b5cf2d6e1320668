#include "server/jobs/worker_needs.h"

#include <algorithm>
#include <sstream>

namespace granary::server {
namespace {

constexpr std::size_t kMaxTags = 16, kMaxLength = 64;

bool is_plain(const std::string& text) {
  return text.size() <= kMaxLength &&
         std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < ' '; });
}

}  // namespace

std::string needs_text(const Tags& tags) {
  std::string text;
  for (const auto& [name, value] : tags) text += name + "=" + value + "\n";
  return text;
}

Tags tags_of_needs(const std::string& needs) {
  Tags tags;
  std::istringstream lines(needs);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    tags[line.substr(0, equals)] = line.substr(equals + 1);
  }
  return tags;
}

bool fulfils(const Tags& worker_tags, const std::string& needs) {
  const Tags wanted = tags_of_needs(needs);
  return std::all_of(wanted.begin(), wanted.end(), [&](const auto& tag) {
    const auto found = worker_tags.find(tag.first);
    return found != worker_tags.end() && found->second == tag.second;
  });
}

Status check_worker_tags(const Tags& tags) {
  if (tags.size() > kMaxTags)
    return Error{ErrorCode::invalid_argument, "worker_tags has more than 16 entries", "worker_tags"};
  for (const auto& [name, value] : tags)
    if (name.empty() || name.find('=') != std::string::npos || !is_plain(name) || !is_plain(value))
      return Error{ErrorCode::invalid_argument,
                   "worker_tags: '" + name + "' must be 1 to 64 printable characters without '=', and so its value",
                   "worker_tags"};
  return Done{};
}

}  // namespace granary::server
