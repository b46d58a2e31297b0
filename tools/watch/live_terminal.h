// The terminal as a screen that is drawn over: the alternate one, without cursor and echo, until destruction.
#pragma once

#include <termios.h>

#include <string>
#include <vector>

namespace unlatch::tools {

class LiveTerminal {
 public:
  LiveTerminal();
  ~LiveTerminal();
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;

  struct Size {
    std::size_t columns, rows;
  };
  // As it is now: it may change between two looks.
  [[nodiscard]] Size get_size() const;
  void show(const std::vector<std::string>& lines);
  // A key that was pressed since the last look, 0 for none.
  [[nodiscard]] char read_key();

 private:
  void write_all(const std::string& text);
  termios before_{};
  bool has_keys_;
};

}  // namespace unlatch::tools
