// A serial port and a clock of the board, for programs that talk to another computer (bridge/target). flight.cc does
// without. Each port of ports/ has these functions beside those of port.h.
#pragma once

#include <cstdint>

namespace unlatch::target {

// Turns the serial port on: 8 bits, no parity, one stop bit.
void open_serial();
// False: nothing has come. A port without a buffer loses what comes while nobody asks.
bool read_serial(std::uint8_t& byte);
// False: there is no place yet.
bool write_serial(std::uint8_t byte);

// Time since the start, us.
std::uint64_t read_clock_us();

// Another number at every start: of a counter in memory that keeps its content, of a generator of random numbers.
std::uint32_t draw_start_number();

}  // namespace unlatch::target
