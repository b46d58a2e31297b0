// Writes an FMU: a zip file with modelDescription.xml, the scenario, and this platform's binary.
#pragma once

// unlatch_write_fmu() of the module unlatch-fmu. `version`: 2 or 3. `text`, `overrides`: of a scenario that loads; each
// override ends in a line break. Null, or a sentence that says why it failed; it
// lives until the next call.
extern "C" const char* unlatch_write_fmu(const char* text, const char* overrides, const char* name, int version,
                                         const char* path);
