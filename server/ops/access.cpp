#include "server/ops/access.h"

#include <array>
#include <random>
#include <sstream>
#include <utility>

#include "proto/contract/sha256.h"

namespace granary::server {
namespace {

constexpr std::array<std::pair<Role, std::string_view>, 4> kRoles = {
    {{Role::read, "read"}, {Role::submit, "submit"}, {Role::worker, "worker"}, {Role::admin, "admin"}}};

// The least role that may call; every RPC stands here, a test walks the descriptors.
constexpr std::array<std::pair<std::string_view, Role>, 27> kCalls = {{
    {"/granary.v1.Admin/Backup", Role::admin},
    {"/granary.v1.Jobs/Submit", Role::submit},
    {"/granary.v1.Jobs/Get", Role::read},
    {"/granary.v1.Jobs/List", Role::read},
    {"/granary.v1.Jobs/Watch", Role::read},
    {"/granary.v1.Jobs/Cancel", Role::submit},
    {"/granary.v1.Jobs/Retry", Role::submit},
    {"/granary.v1.Jobs/Delete", Role::submit},
    {"/granary.v1.Jobs/GetValues", Role::read},
    {"/granary.v1.Jobs/GetLogs", Role::read},
    {"/granary.v1.Jobs/Download", Role::read},
    {"/granary.v1.Jobs/GetServerInfo", Role::read},
    {"/granary.v1.Studies/Submit", Role::submit},
    {"/granary.v1.Studies/Get", Role::read},
    {"/granary.v1.Studies/List", Role::read},
    {"/granary.v1.Studies/Watch", Role::read},
    {"/granary.v1.Studies/Pause", Role::submit},
    {"/granary.v1.Studies/Resume", Role::submit},
    {"/granary.v1.Studies/Extend", Role::submit},
    {"/granary.v1.Studies/Cancel", Role::submit},
    {"/granary.v1.Studies/ListTrials", Role::read},
    {"/granary.v1.Query/Run", Role::read},
    {"/granary.v1.Query/GetSchema", Role::read},
    {"/granary.v1.Workers/Synchronize", Role::worker},
    {"/granary.v1.Workers/Upload", Role::worker},
    {"/granary.v1.Workers/FetchArtifact", Role::worker},
    {"/granary.v1.Workers/List", Role::read},
}};

Error bad_line(const std::string& file, int line, const std::string& what) {
  return {ErrorCode::invalid_argument, file + ":" + std::to_string(line) + ": " + what, "tokens"};
}

}  // namespace

std::optional<Role> role_from(std::string_view text) {
  for (const auto& [role, name] : kRoles)
    if (name == text) return role;
  return {};
}

std::string_view role_name(Role role) {
  for (const auto& [each, name] : kRoles)
    if (each == role) return name;
  return "";
}

bool may_call(Role role, std::string_view path) {
  if (role == Role::admin) return true;
  for (const auto& [call, least] : kCalls) {
    if (call != path) continue;
    if (least == Role::admin) return false;
    if (least == Role::worker || role == Role::worker) return least == role;
    return least == Role::read || role == Role::submit;
  }
  return false;
}

bool is_open(std::string_view path) {
  return path.rfind("/grpc.health.v1.Health/", 0) == 0 ||
         path.rfind("/grpc.reflection.v1alpha.ServerReflection/", 0) == 0;
}

Result<TokenTable> TokenTable::parse(std::string_view text, const std::string& file_name) {
  TokenTable table;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string hash, role_text, rest;
    TokenOwner owner;
    words >> hash >> role_text >> owner.owner;
    if (!(words >> owner.expires_s)) owner.expires_s = 0, words.clear();
    const auto role = role_from(role_text);
    if (!is_sha256_hex(hash)) return bad_line(file_name, number, "does not start with a SHA-256");
    if (!role) return bad_line(file_name, number, "role '" + role_text + "' is not read, submit, worker or admin");
    if (owner.owner.empty()) return bad_line(file_name, number, "names no owner");
    if (words >> rest) return bad_line(file_name, number, "has '" + rest + "' too much");
    owner.role = *role;
    table.by_hash_[hash] = owner;
  }
  return table;
}

std::optional<TokenOwner> TokenTable::find(std::string_view token, std::int64_t now_s) const {
  // Looked up by hash, so the time taken says nothing about how much of a token was right.
  const auto found = by_hash_.find(sha256_hex(token));
  if (found == by_hash_.end()) return {};
  if (found->second.expires_s != 0 && found->second.expires_s <= now_s) return {};
  return found->second;
}

NewToken make_token(const TokenOwner& owner) {
  std::random_device random;  // the kernel's generator on this platform
  char word[9];
  NewToken made;
  for (int i = 0; i < 8; ++i) {
    std::snprintf(word, sizeof word, "%08x", random());
    made.token += word;
  }
  made.line = sha256_hex(made.token) + " " + std::string(role_name(owner.role)) + " " + owner.owner;
  if (owner.expires_s != 0) made.line += " " + std::to_string(owner.expires_s);
  return made;
}

}  // namespace granary::server
