// The sources of an FMU, for other platforms: the files that its binary is made of, and how to compile them.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace unlatch::fmi {

// Files by their paths in the repository, from an archive beside the module (unlatch-fmu-sources.tar). Empty if there
// is none.
std::map<std::string, std::string> read_sources(const std::string& archive);

// Those that are compiled for every platform.
std::vector<std::string> list_compiled(const std::map<std::string, std::string>& sources);

// sources/buildDescription.xml of FMI 3.0.
std::string describe_build(const std::map<std::string, std::string>& sources, const std::string& identifier);

}  // namespace unlatch::fmi
