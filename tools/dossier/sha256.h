// SHA-256 of a text, as sha256sum prints it.
#pragma once

#include <string>

namespace unlatch::tools {

std::string calc_sha256(const std::string& text);

}  // namespace unlatch::tools
