// The readers of CalculiX's output: meshes and shapes (.frd), frequencies (.dat).
#include "tests/fuzz/fuzz.h"
#include "tools/modes/calculix.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::to_text(data, size);
  try {
    const tools::MeshModes modes = tools::parse_frd(text, "fuzz.frd");
    fuzz::require(modes.displacements.size() == modes.frequencies_hz.size(), "a mode without a shape");
    for (const auto& shape : modes.displacements)
      fuzz::require(shape.size() == modes.mesh.nodes.size(), "a shape of other nodes");
  } catch (const tools::CalculixError&) {
  }
  try {
    for (const double frequency : tools::parse_dat(text, "fuzz.dat"))
      fuzz::require(frequency >= 0, "a frequency below 0");
  } catch (const tools::CalculixError&) {
  }
  return 0;
}
