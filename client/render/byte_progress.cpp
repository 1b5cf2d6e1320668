#include "client/render/byte_progress.h"

#include <iostream>

#include "client/render/progress_line.h"

namespace granary::render {

void ByteProgress::show(std::uint64_t have_bytes, std::uint64_t size_bytes) {
  const int percent = size_bytes == 0 ? 100 : static_cast<int>(100 * have_bytes / size_bytes);
  if (!shown_ || percent == percent_) return;
  percent_ = percent;
  std::cerr << "\r[" << bar(percent / 100.0, 20) << "] " << percent << " %" << std::flush;
}

void ByteProgress::close() const {
  if (percent_ >= 0) std::cerr << "\n";
}

}  // namespace granary::render
