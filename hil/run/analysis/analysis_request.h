// Parts of a run's analysis that its caller requests. A part that is not requested costs nothing and is absent; the
// other results keep the same bits.
#pragma once

namespace unlatch::hil {

// Optional parts. Events, notices of what is not resolved, clearances, contacts, separations and requirements belong to
// every analysis. By default every part is requested, as for a run that people look at.
struct AnalysisRequest {
  bool accuracy = true;    // the notices that cost the most: drift, and the audit of energy
  bool reactions = true;   // peak reactions
  bool redundancy = true;  // reactions that are not unique, and the times at which they are not
  bool pushes = true;      // impulse and work of the springs that separate assemblies
  bool touches = true;     // each touch of a contact, beside the whole
};

}  // namespace unlatch::hil
