// The plan and the session image in flash; CMakeLists.txt writes their definition.
#pragma once

#include <cstddef>

extern "C" const std::byte target_plan[], target_plan_end[], target_session[], target_session_end[];
