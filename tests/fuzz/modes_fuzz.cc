// The reader of modes files, and the flexible bodies made from them.
#include <stdexcept>

#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/flexible/modes_file.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const hil::Modes modes = hil::read_modes_text(fuzz::to_text(data, size), "fuzz.modes");
    const std::string written = hil::write_modes_text(modes);
    fuzz::require(hil::write_modes_text(hil::read_modes_text(written, "written.modes")) == written,
                  "a file that does not read back as it was written");
    hil::FlexibleReport report;
    const hil::FlexibleStructure structure = hil::build_flexible_body(modes, {}, report);
    fuzz::require(std::isfinite(structure.mass) && structure.inertia.allFinite(), "a body of numbers that are none");
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  } catch (const std::invalid_argument&) {  // modes that are no flexible body; the loader reports it
  }
  return 0;
}
