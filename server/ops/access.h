// Who may call what. Tokens are kept as SHA-256 only; a file of them, one a line:
//   <sha256 of the token> <role> <owner> [<expiry, seconds since 1970>]
// Roles: read sees everything; submit also changes jobs; worker speaks the worker protocol and nothing
// else; admin may do all. Pure but for reading the file: the clock is an argument.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "proto/contract/result.h"

namespace granary::server {

enum class Role { read, submit, worker, admin };

std::optional<Role> role_from(std::string_view text);
std::string_view role_name(Role role);

// May `role` call the RPC with this path ("/granary.v1.Jobs/Submit")? Unknown paths: admin only.
bool may_call(Role role, std::string_view path);
// Health and reflection need no token.
bool is_open(std::string_view path);

struct TokenOwner {
  Role role = Role::read;
  std::string owner;
  std::int64_t expires_s = 0;  // 0 = never
};

class TokenTable {
 public:
  // INVALID_ARGUMENT names the line.
  static Result<TokenTable> parse(std::string_view text, const std::string& file_name);

  // Nothing for unknown and expired tokens. `token` as the user holds it.
  std::optional<TokenOwner> find(std::string_view token, std::int64_t now_s) const;
  std::size_t size() const { return by_hash_.size(); }

 private:
  std::unordered_map<std::string, TokenOwner> by_hash_;
};

// A new token of 256 random bits as hex, and its line for the file.
struct NewToken {
  std::string token;
  std::string line;
};
NewToken make_token(const TokenOwner& owner);

}  // namespace granary::server
