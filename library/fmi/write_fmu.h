// Writes an FMU: a zip file with modelDescription.xml, the scenario, and this platform's binary.
#pragma once

// Function unlatch_write_fmu() of the module unlatch-fmu. `version`: 2 or 3. `text`, `overrides`: of a valid scenario;
// each override ends in a line break. Returns null, or a sentence with the reason of the failure, which is valid until
// the next call.
extern "C" const char* unlatch_write_fmu(const char* text, const char* overrides, const char* name, int version,
                                         const char* path);
