#include "client/render/progress_display.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>

#include "client/render/progress_line.h"
#include "client/render/table.h"
#include "proto/contract/job_state.h"

namespace granary::render {
namespace {

constexpr double kPlainInterval_s = 1.0;
constexpr double kLiveInterval_s = 0.1;

}  // namespace

Terminal terminal_of_stderr() {
  Terminal terminal;
  terminal.is_terminal = isatty(STDERR_FILENO) == 1;
  const char* no_color = std::getenv("NO_COLOR");
  terminal.ansi = terminal.is_terminal && (no_color == nullptr || *no_color == '\0');
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col >= 20)
    terminal.width = size.ws_col;
  return terminal;
}

ProgressDisplay::ProgressDisplay(std::ostream& out, Terminal terminal, std::string job)
    : out_(out), terminal_(terminal), job_(std::move(job)) {}

void ProgressDisplay::show(const v1::JobEvent& event, double now_s) {
  if (event.what_case() == v1::JobEvent::kState) show_state(event.state(), event.message());
  if (event.what_case() == v1::JobEvent::kProgress) show_progress(event.progress(), now_s);
}

void ProgressDisplay::show_state(v1::JobState state, const std::string& message) {
  if (state == v1::COMPLETE) {
    v1::Progress all;
    all.set_fraction(1);
    erase();
    out_ << job_ << ": " << progress_line(all) << "  complete";
    if (!message.empty()) out_ << ": " << printable(message);
    out_ << "\n" << std::flush;
    return;
  }
  erase();
  out_ << job_ << ": " << to_string(state);
  if (!message.empty()) out_ << ": " << printable(message);
  out_ << "\n" << std::flush;
}

void ProgressDisplay::show_progress(const v1::Progress& progress, double now_s) {
  const double interval_s = terminal_.is_terminal ? kLiveInterval_s : kPlainInterval_s;
  if (now_s - shown_at_s_ < interval_s && progress.fraction() < 1) return;
  shown_at_s_ = now_s;
  if (terminal_.is_terminal)
    draw(progress);
  else
    out_ << job_ << ": " << progress_line(progress) << "\n" << std::flush;
}

void ProgressDisplay::draw(const v1::Progress& progress) {
  const std::size_t width = terminal_.width - 1;  // the last column would wrap on some terminals
  auto lines = progress_lines(progress, width);
  if (!terminal_.ansi) {
    // A carriage return is all there is: one line, padded over what was there.
    std::string line = progress_line(progress).substr(0, width);
    line.resize(width, ' ');
    out_ << '\r' << line << std::flush;
    lines_drawn_ = 1;
    return;
  }
  erase();
  for (std::size_t i = 0; i < lines.size(); ++i) out_ << (i > 0 ? "\n" : "") << lines[i];
  out_ << std::flush;
  lines_drawn_ = lines.size();
}

void ProgressDisplay::erase() {
  if (lines_drawn_ == 0) return;
  out_ << '\r';
  if (!terminal_.ansi)
    out_ << std::string(terminal_.width - 1, ' ') << '\r';
  else if (lines_drawn_ > 1)
    out_ << "\x1b[" << lines_drawn_ - 1 << "A\x1b[J";
  else
    out_ << "\x1b[J";
  lines_drawn_ = 0;
}

void ProgressDisplay::close() {
  if (lines_drawn_ > 0) out_ << "\n" << std::flush;
  lines_drawn_ = 0;
}

}  // namespace granary::render
