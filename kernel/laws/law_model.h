// Laws and tables of a model: which of them forces read, their order, their mistakes, their part of a plan.
#pragma once

#include <vector>

#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"

namespace unlatch {

// Adds mistakes of tables, and those of laws where nothing else is wrong: laws read the rest of the model.
void validate_laws(const Model& model, ModelErrors& errors);

// Appends PlanData::laws, and finds the coordinates that laws read which forces read.
void compile_laws(const Model& model, ElementCompiler& compiler);

}  // namespace unlatch
