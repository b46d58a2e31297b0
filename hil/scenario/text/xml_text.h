// Text for XML, as the content of an element or the value of an attribute in quotes.
#pragma once

#include <string>

namespace unlatch::hil {

// Escapes a text and removes the control characters that XML forbids.
std::string escape_xml(const std::string& text);

}  // namespace unlatch::hil
