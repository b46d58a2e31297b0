// An FMU from an unknown source, without its binary: the zip file, and modelDescription.xml.
//
//   input  = choice (1 byte: even a zip file, odd a description), then its bytes
#include <algorithm>
#include <filesystem>

#include "tests/fuzz/fuzz.h"
#include "tools/fmu/description.h"
#include "tools/fmu/zip_file.h"

using namespace unlatch;

namespace {

// Returns true if a name stays inside the folder; "a..b" is an ordinary name.
bool stays_inside(const std::filesystem::path& name) {
  return !name.empty() && name.is_relative() && std::find(name.begin(), name.end(), "..") == name.end();
}

void read_zip(const std::string& bytes) {
  const fmu::ZipFile file(bytes);
  for (const auto& [name, member] : file.members()) {
    fuzz::require(stays_inside(name), "a member whose name leads out of the folder");
    try {
      const std::string content = file.read(name);
      fuzz::require(content.size() == member.length, "a member of another length than its header states");
      if (name == "modelDescription.xml") (void)fmu::read_description(content);
    } catch (const fmu::FmuError&) {
    }
  }
}

void read_description(const std::string& text) {
  const fmu::Description description = fmu::read_description(text);
  fuzz::require(description.version == 2 || description.version == 3, "a version of FMI that is unknown");
  fuzz::require(!description.identifier.empty() && description.identifier.find('/') == std::string::npos,
                "a binary whose name leads out of its folder");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    if (data[0] % 2 == 0)
      read_zip(fuzz::to_text(data + 1, size - 1));
    else
      read_description(fuzz::to_text(data + 1, size - 1));
  } catch (const fmu::FmuError& error) {
    fuzz::require(error.what()[0] != 0, "a refusal without a reason");
  }
  return 0;
}
