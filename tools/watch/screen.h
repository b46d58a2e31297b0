// Draws a View: lines of text for a terminal of a given size, and one line for everything else.
#pragma once

#include <string>
#include <vector>

#include "tools/watch/view.h"

namespace unlatch::tools {

struct ScreenOptions {
  std::size_t columns = 80, rows = 24;
  bool colours = true;
  std::string transport;  // "dds", for the first line
};

// At most `rows` lines of at most `columns` characters. What does not fit is left out and counted.
std::vector<std::string> draw(const View& view, const ScreenOptions& options);

// "t 1.234 s, tick 1234, running; 4 of 4 joints …": for a file, a line a second.
std::string describe(const View& view);

// The same as one line of JSON.
std::string build_json(const View& view);

}  // namespace unlatch::tools
