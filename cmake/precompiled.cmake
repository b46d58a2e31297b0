# Precompiled headers: the standard library, Eigen and (for tests) GoogleTest are read once, not two hundred times. AUTO leaves
# them out where a compiler cache works: it would not find again what was compiled with a precompiled header.
set(UNLATCH_PCH AUTO CACHE STRING "Precompiled headers: ON, OFF, or AUTO: unless a compiler launcher such as ccache is set")
set(unlatch_pch ${UNLATCH_PCH})
if(UNLATCH_PCH STREQUAL "AUTO")
  set(unlatch_pch ON)
  if(CMAKE_CXX_COMPILER_LAUNCHER)
    set(unlatch_pch OFF)
  endif()
endif()

set(unlatch_pch_headers <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstdio> <functional> <map> <memory> <optional>
  <span> <stdexcept> <string> <string_view> <thread> <utility> <vector> <Eigen/Core> <Eigen/Geometry>)

# unlatch_precompile(KIND TARGET...): these targets read the headers of KIND: `library` or `test`. KIND's own target,
# unlatch_pch_KIND, has the flags that all of them share.
function(unlatch_precompile kind)
  if(unlatch_pch)
    foreach(target IN LISTS ARGN)
      target_precompile_headers(${target} REUSE_FROM unlatch_pch_${kind})
      set_target_properties(${target} PROPERTIES PCH_WARN_INVALID OFF)
      # g++ 12 forgets that a precompiled header is a system's, and warns of its own std::string (GCC bug 105651).
      target_compile_options(${target} PRIVATE
        $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-maybe-uninitialized>)
    endforeach()
  endif()
endfunction()

# unlatch_add_precompiled(KIND HEADERS HEADER... LINK LIBRARY...)
function(unlatch_add_precompiled kind)
  if(NOT unlatch_pch)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 pch "" "" "HEADERS;LINK")
  set(source ${CMAKE_CURRENT_BINARY_DIR}/pch_${kind}.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "int main() {}\n")
  if(kind STREQUAL "test")
    add_executable(unlatch_pch_${kind} ${source})  # -fPIE, as tests are
  else()
    add_library(unlatch_pch_${kind} STATIC ${source})
  endif()
  target_link_libraries(unlatch_pch_${kind} PRIVATE unlatch_options Eigen3::Eigen ${pch_LINK})
  target_precompile_headers(unlatch_pch_${kind} PRIVATE ${unlatch_pch_headers} ${pch_HEADERS})
endfunction()
