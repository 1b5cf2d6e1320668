// SHA-256 of bytes that arrive in pieces: the checksum of every artifact, on all three sides.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace granary {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(const void* data, std::size_t bytes);
  void update(std::string_view bytes) { update(bytes.data(), bytes.size()); }
  std::string hex();  // 64 digits; ends the computation

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

std::string sha256_hex(std::string_view bytes);
bool is_sha256_hex(std::string_view text);  // 64 lower-case digits: safe as a file name

}  // namespace granary
