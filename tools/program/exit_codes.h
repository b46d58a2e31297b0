// Exit codes; scripts may rely on them.
#pragma once

namespace unlatch::tools {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;       // the run or the comparison failed: a fault, an abort, a difference
inline constexpr int kExitUsage = 2;        // the command line or an input file is wrong
inline constexpr int kExitEnvironment = 3;  // no permission, no middleware, no space

}  // namespace unlatch::tools
