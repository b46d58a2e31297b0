#include "bridge/uart/serial_line.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace unlatch::bridge {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostWaiting = std::size_t{1} << 18;
constexpr std::size_t kReadBytes = 4096;
constexpr int kBitsOfByte = 10;   // start, eight bits, stop
constexpr auto kAhead = 5ms;      // of what is given to the system before the line has sent it
constexpr auto kSilence = 500ms;  // after which a frame that has begun is not continued
constexpr auto kIdlePeriod = 100ms;
constexpr auto kReopenEvery = 200ms;
constexpr auto kLinger = 1s;

struct Speed {
  int baud;
  speed_t code;
};
constexpr Speed kSpeeds[] = {{9600, B9600},       {19200, B19200},     {38400, B38400},     {57600, B57600},
                             {115200, B115200},   {230400, B230400},   {460800, B460800},   {500000, B500000},
                             {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000},
                             {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000},
                             {3500000, B3500000}, {4000000, B4000000}};

const Speed* find_speed(int baud) {
  const auto* const found =
      std::find_if(std::begin(kSpeeds), std::end(kSpeeds), [&](const Speed& s) { return s.baud == baud; });
  return found == std::end(kSpeeds) ? nullptr : found;
}

// 8 bits, no parity, one stop bit, no flow control, nothing translated. −1, with errno, if it cannot be had.
int open_line(const UartOptions& options) {
  const int file = open(options.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return -1;
  termios settings{};
  const Speed* const speed = find_speed(options.baud);
  bool good = tcgetattr(file, &settings) == 0 && speed != nullptr;
  if (good) {
    cfmakeraw(&settings);
    settings.c_cflag = (settings.c_cflag & ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL)) | CLOCAL | CREAD;
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    good = cfsetspeed(&settings, speed->code) == 0 && tcsetattr(file, TCSANOW, &settings) == 0;
  }
  if (good) return file;
  const int error = errno;
  close(file);
  errno = error;
  return -1;
}

int open_or_throw(const UartOptions& options) {
  if (find_speed(options.baud) == nullptr) {
    throw PortError("UART: " + std::to_string(options.baud) +
                    " is no rate that serial ports of this system have; take 115200, 921600 or 3000000");
  }
  const int file = open_line(options);
  if (file >= 0) return file;
  throw PortError("UART: " + options.device + " cannot be opened: " + std::strerror(errno) +
                  (errno == EACCES   ? "; your user must be in the group of the file (`ls -l`), mostly dialout"
                   : errno == ENOTTY ? "; it is no serial port"
                                     : "; `ls /dev/tty*` lists the ports of this machine"));
}

}  // namespace

SerialLine::SerialLine(const UartOptions& options, Events events)
    : options_(options),
      events_(std::move(events)),
      wake_event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      file_(open_or_throw(options)) {
  if (wake_event_.get() < 0) {
    close(file_);
    throw_port_error("UART", "opening an eventfd");
  }
  free_at_ = heard_ = Clock::now();
  thread_ = std::jthread([this] { run(); });
}

SerialLine::~SerialLine() {
  for (const auto end = Clock::now() + kLinger; count_waiting() > 0 && Clock::now() < end;)
    std::this_thread::sleep_for(1ms);
  stopping_ = true;
  wake();
  thread_.join();
  if (file_ >= 0) close(file_);
}

bool SerialLine::write(std::span<const std::uint8_t> bytes) {
  {
    const std::scoped_lock lock(mutex_);
    if (waiting_.size() + bytes.size() > kMostWaiting) return false;
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  }
  wake();
  return true;
}

void SerialLine::wake() {
  const std::uint64_t one = 1;
  (void)!::write(wake_event_.get(), &one, sizeof one);
}

std::size_t SerialLine::count_waiting() const {
  const std::scoped_lock lock(mutex_);
  return waiting_.size();
}

SerialLine::Clock::duration SerialLine::get_time(std::size_t bytes) const {
  return std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(static_cast<double>(bytes) * kBitsOfByte / options_.baud));
}

void SerialLine::run() {
  Clock::time_point next_idle = Clock::now() + kIdlePeriod;
  while (!stopping_) {
    const Clock::time_point now = Clock::now();
    const bool is_free = free_at_ <= now + kAhead;
    if (is_free && count_waiting() == 0) events_.free();
    const bool may_write = is_free && count_waiting() > 0;
    Clock::time_point until = next_idle;
    if (!is_silent_) until = std::min(until, heard_ + kSilence);
    if (!is_free) until = std::min(until, free_at_ - kAhead / 2);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(std::max(until - now, Clock::duration::zero()));
    std::array<pollfd, 2> events{
        {{file_, static_cast<short>(POLLIN | (may_write ? POLLOUT : 0)), 0}, {wake_event_.get(), POLLIN, 0}}};
    if (poll(events.data(), events.size(), static_cast<int>(left.count())) < 0 && errno != EINTR) return;
    std::uint64_t woken = 0;
    if (events[1].revents != 0) (void)!::read(wake_event_.get(), &woken, sizeof woken);
    if (file_ < 0 || (events[0].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0)
      reopen();
    else if ((events[0].revents & POLLIN) != 0)
      read_all();
    if (may_write && file_ >= 0 && (events[0].revents & POLLOUT) != 0) write_some();
    if (!is_silent_ && Clock::now() - heard_ >= kSilence) {
      is_silent_ = true;
      events_.silent();
    }
    if (Clock::now() >= next_idle) {
      events_.idle();
      next_idle = Clock::now() + kIdlePeriod;
    }
  }
}

void SerialLine::read_all() {
  std::array<std::uint8_t, kReadBytes> bytes;
  for (int i = 0; i < 16; ++i) {  // then other work has its turn
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count <= 0) return;
    heard_ = Clock::now();
    is_silent_ = false;
    events_.read(std::span(bytes).first(static_cast<std::size_t>(count)));
  }
}

// As much as the line sends until a little later.
void SerialLine::write_some() {
  const std::scoped_lock lock(mutex_);
  const double seconds = std::chrono::duration<double>(kAhead).count();
  const auto share = static_cast<std::size_t>(seconds * options_.baud / kBitsOfByte) + 1;
  const ssize_t count = ::write(file_, waiting_.data(), std::min(waiting_.size(), share));
  if (count <= 0) return;
  waiting_.erase(waiting_.begin(), waiting_.begin() + count);
  free_at_ = std::max(free_at_, Clock::now()) + get_time(static_cast<std::size_t>(count));
}

// Nothing that waits is of use once the other end has been away.
void SerialLine::reopen() {
  if (file_ >= 0) close(std::exchange(file_, -1));
  {
    const std::scoped_lock lock(mutex_);
    waiting_.clear();
  }
  const auto end = Clock::now() + kReopenEvery;
  while (!stopping_ && Clock::now() < end) std::this_thread::sleep_for(10ms);
  file_ = open_line(options_);
}

}  // namespace unlatch::bridge
