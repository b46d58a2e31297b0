// Sources of an FMU, for other platforms: the files of its binary, and the compiler's options.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace unlatch::fmi {

// Reads files by their paths in the repository, from an archive beside the module (unlatch-fmu-sources.tar). Empty if
// there is none.
std::map<std::string, std::string> read_sources(const std::string& archive);

// Sources that are compiled for every platform.
std::vector<std::string> list_compiled(const std::map<std::string, std::string>& sources);

// Text of sources/buildDescription.xml of FMI 3.0.
std::string describe_build(const std::map<std::string, std::string>& sources, const std::string& identifier);

}  // namespace unlatch::fmi
