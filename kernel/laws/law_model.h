// Laws and tables of a model: which of them forces read, their order, their mistakes, their part of a plan.
#pragma once

#include <vector>

#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"

namespace unlatch {

void validate_tables(const Model& model, ModelErrors& errors);
// Needs valid tables, quantities and elements: their mistakes are reported before.
void validate_laws(const Model& model, ModelErrors& errors);

// Appends PlanData::laws, and finds the coordinates that laws read which forces read. Needs the elements and the
// quantities of the plan.
void compile_laws(const Model& model, ElementCompiler& compiler);

}  // namespace unlatch
