// Parts of a run's analysis that its caller asks for. What is not asked for costs nothing and is not there; all the
// rest has the same bits.
#pragma once

namespace unlatch::hil {

// Events, clearances, contacts, separations and requirements belong to every analysis. By default everything is asked
// for, as for a run that people look at.
struct AnalysisRequest {
  bool accuracy = true;    // notices, and the audit of energy
  bool reactions = true;   // their peaks
  bool redundancy = true;  // which reactions are not unique, and when
  bool pushes = true;      // impulse and work of the springs that part assemblies
};

}  // namespace unlatch::hil
