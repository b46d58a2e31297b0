// Text for XML, as the content of an element or the value of an attribute in quotes.
#pragma once

#include <string>

namespace unlatch::hil {

// Without the control characters that XML cannot have.
std::string escape_xml(const std::string& text);

}  // namespace unlatch::hil
