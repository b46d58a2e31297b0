// Numbers and words as text.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "hil/scenario/text/count.h"
#include "unlatch/model.h"

namespace unlatch::tools {

// As std::printf; at most 511 characters.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

// Six digits.
std::string to_short_text(double value);

// The value, but 0 where it is what rounding leaves of numbers of this size.
inline double drop_rounding(double value, double size) { return std::abs(value) < 1e-12 * size ? 0 : value; }

using hil::count;

// Characters that a terminal shows: the bytes that begin one.
std::size_t count_characters(std::string_view text);

// A hash: 16 digits.
std::string to_hex(std::int64_t hash);
std::string to_hex(std::uint64_t hash);

// A cell of a table in CSV (RFC 4180): between quotation marks if it needs them.
std::string quote_cell(const std::string& text);

// Name of a body; `ground`: of what is none.
std::string get_body_name(const Model& model, int body, const char* ground = "ground");

}  // namespace unlatch::tools
