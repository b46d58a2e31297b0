// Files of others are read by libraries of others: bounded beforehand, and in a process of its own, so that what such a
// library does to its process is a sentence here.
#pragma once

#include <functional>
#include <string>

namespace unlatch::tools {

// The text of a regular file that is plausible XML: at most 16 MiB, no NUL, no DTD, at most 64 elements deep. Throws
// ImportError.
std::string read_xml(const std::string& path);

// Result of `work`, computed in a child process with bounded memory and time. Throws ImportError with the child's
// exception, or with the reason of its death. This process must have one thread.
std::string compute_apart(const std::function<std::string()>& work);

}  // namespace unlatch::tools
