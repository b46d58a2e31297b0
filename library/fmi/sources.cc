#include "library/fmi/sources.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "hil/scenario/text/xml_text.h"

namespace unlatch::fmi {
namespace {

using hil::escape_xml;

// Options for the bits of the binary: no compiler may fuse a multiply with an add (cmake/compile_options.cmake).
constexpr const char* kOptions = "-std=c++20 -O2 -fPIC -ffp-contract=off -fno-tree-slp-vectorize";

// Files of the kernel that need an instruction set of x86-64, and the option that enables it.
struct WideFile {
  const char *path, *options;
};
constexpr WideFile kWide[] = {{"kernel/dispatch/avx2.cc", "-mavx2"},
                              {"kernel/dispatch/avx512.cc", "-mavx512f -mavx512dq -mavx512vl"}};

bool is_wide(const std::string& path) {
  for (const WideFile& wide : kWide)
    if (path == wide.path) return true;
  return false;
}

std::string describe_set(const std::vector<std::string>& files, const std::string& options) {
  std::string xml = "    <SourceFileSet language=\"C++20\" compiler=\"g++\" compilerOptions=\"" + options + "\">\n";
  for (const std::string& file : files) xml += "      <SourceFile name=\"" + escape_xml(file) + "\"/>\n";
  xml += "      <PreprocessorDefinition name=\"EIGEN_DONT_VECTORIZE\"/>\n";
  xml += "      <PreprocessorDefinition name=\"UNLATCH_VERSION\" value=\"" +
         escape_xml(std::string("\"") + UNLATCH_VERSION + "\"") + "\"/>\n";
  xml += "      <PreprocessorDefinition name=\"UNLATCH_MODULES\" value=\"&quot;.&quot;\"/>\n";
  for (const char* const folder : {".", "kernel/include", "library/include"})
    xml += std::string("      <IncludeDirectory name=\"") + folder + "\"/>\n";
  return xml + "    </SourceFileSet>\n";
}

}  // namespace

// Format of POSIX tar, without links and long names: blocks of 512 bytes; a name at 0, an octal length at 124.
std::map<std::string, std::string> read_sources(const std::string& archive) {
  constexpr std::size_t kBlock = 512, kLength = 124, kType = 156, kPrefix = 345;
  std::ifstream file(archive, std::ios::binary);
  std::ostringstream stream;
  stream << file.rdbuf();
  const std::string bytes = stream.str();
  std::map<std::string, std::string> sources;
  for (std::size_t at = 0; at + kBlock <= bytes.size() && bytes[at] != '\0';) {
    const std::string prefix = bytes.c_str() + at + kPrefix;
    const std::string name = (prefix.empty() ? "" : prefix + "/") + std::string(bytes.substr(at, 100).c_str());
    const std::size_t length = std::strtoul(bytes.substr(at + kLength, 12).c_str(), nullptr, 8);
    if (bytes[at + kType] == '0') sources[name] = bytes.substr(at + kBlock, length);
    at += kBlock + (length + kBlock - 1) / kBlock * kBlock;
  }
  return sources;
}

std::vector<std::string> list_compiled(const std::map<std::string, std::string>& sources) {
  std::vector<std::string> files;
  for (const auto& [name, text] : sources)
    if (name.ends_with(".cc") && !is_wide(name)) files.push_back(name);
  return files;
}

std::string describe_build(const std::map<std::string, std::string>& sources, const std::string& identifier) {
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n";
  for (const char* const platform : {"x86_64-linux", "aarch64-linux"}) {
    xml += "  <BuildConfiguration modelIdentifier=\"" + identifier + "\" platform=\"" + platform + "\">\n";
    xml += describe_set(list_compiled(sources), kOptions);
    if (std::string(platform) == "x86_64-linux")
      for (const WideFile& wide : kWide) xml += describe_set({wide.path}, std::string(kOptions) + " " + wide.options);
    xml +=
        "    <Library name=\"Eigen3\" version=\"3.4\" external=\"true\" description=\"headers alone; their folder is "
        "an "
        "include directory\"/>\n    <Library name=\"yaml-cpp\" version=\"0.7\" external=\"true\"/>\n"
        "  </BuildConfiguration>\n";
  }
  return xml + "</fmiBuildDescription>\n";
}

}  // namespace unlatch::fmi
