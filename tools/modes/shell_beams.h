// Modes of a half shell that are those of the curved beam: matched by shape, not by number.
#pragma once

#include <vector>

#include "hil/scenario/flexible/modes_file.h"
#include "tools/modes/curved_beam.h"
#include "tools/modes/shell_mesh.h"

namespace unlatch::tools {

// Frequency of an arc's Ω for a strip of the shell's wall, Hz: EJ per length E d³/12, for a plate over 1 − ν².
double calc_arc_hz(double omega, double radius, double thickness, double young, double density, double poisson,
                   bool plate);

struct ShellModeFinding {
  bool even = false;    // mirrored about the plane x = 0 it is itself
  double symmetry = 0;  // share of its modal mass that has that symmetry
  int beam = 0;         // the arc's mode, from 1; 0: none
  double likeness = 0;  // MAC with that mode over the cylinder, any amplitude that is linear along it
};

// `arc`: modes of kInextensional over π. Each is given to the shell mode that is most like it, by the modal assurance
// criterion over the mass points of the cylinder.
std::vector<ShellModeFinding> match_beams(const hil::Modes& modes, const HalfShell& shell,
                                          const std::vector<ArcMode>& arc);

}  // namespace unlatch::tools
