// SIGINT and SIGTERM end a tool in an orderly way.
#pragma once

#include <atomic>

namespace unlatch::tools {

// From now on both signals set the flag that this returns, for as long as the process lives.
const std::atomic<bool>& catch_interrupts();

}  // namespace unlatch::tools
