# Compile options of every target. Link `unlatch_options` (PRIVATE) to every target.
#
# Same bits everywhere: no compiler may fuse a multiply with an add. -ffp-contract=off says so, but g++ 12's SLP vectoriser
# fuses in spite of it and has been seen to compute wrong physics from -O2 on, so it is off as well; tests/kernel
# disassembles the kernel and refuses any fused multiply-add. Never -ffast-math, never -march=native.
add_library(unlatch_options INTERFACE)
target_include_directories(unlatch_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(unlatch_options INTERFACE
  -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>
  $<$<CXX_COMPILER_ID:Clang>:-fno-slp-vectorize>
  -Wall -Wextra -Wconversion -Wshadow -Wdouble-promotion
  # g++ 12 sees an overlap in "text" + std::string (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${UNLATCH_WERROR}>:-Werror>)
# Eigen's packet code has FMA intrinsics and sums whose order depends on buffer addresses.
target_compile_definitions(unlatch_options INTERFACE EIGEN_DONT_VECTORIZE)

# g++ collects its garbage later: some 400 MB more for the largest files, and a twentieth less time.
add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=400000>)

# The sanitizers: cmake -DUNLATCH_SANITIZE="address,undefined" (see CMakePresets.json).
set(UNLATCH_SANITIZE "" CACHE STRING "Comma-separated sanitizers for the whole build")
if(UNLATCH_SANITIZE)
  add_compile_options(-fsanitize=${UNLATCH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
  add_link_options(-fsanitize=${UNLATCH_SANITIZE})
endif()
