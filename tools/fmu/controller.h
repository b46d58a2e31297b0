// A controller FMU as a control law: its inputs are sensors and states, its outputs channels, matched by name.
//
//   input    NAME or sensors.NAME: a sensor's value (gyro.x); bodies.NAME.position.x, .attitude.w, .velocity.x,
//            .angular_velocity.x: of a body, in the units and axes of State
//   output   NAME or channels.NAME: a channel
//
// Variables with other names are mapped to these; an input that is mapped to "-" keeps its start value.
//
// At tick 0 it is initialized with that tick's inputs; at every later tick it gets that tick's inputs and steps up to
// it. So its outputs answer the State that they are sent for, as those of other flight software do. An output is a
// command when it differs from the one before.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "tools/fsw/control_law.h"

namespace unlatch::fmu {

// Names in the scenario of the variables of an FMU: "In1" → "gyro.x".
using NameMap = std::map<std::string, std::string>;

// Unpacks and loads an FMU, and instantiates it once to see that it can be. Throws fsw::ControlError, also for names in
// `names` that no input or output of the FMU has.
std::unique_ptr<fsw::ControlLaw> open_controller(const std::string& path, const NameMap& names);

}  // namespace unlatch::fmu
