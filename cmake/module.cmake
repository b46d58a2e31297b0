# Modules: shared libraries that a program loads when it first needs them (hil/scenario/base/module.h). They lie beside the
# programs in the same way in the build folder and where they are installed.
set(UNLATCH_MODULES ${CMAKE_INSTALL_LIBDIR}/unlatch)

# unlatch_add_module(NAME SOURCE... LINK LIBRARY... EXPORT FUNCTION...): the module libNAME.so. It exports these extern "C"
# functions and nothing of the static libraries in it.
function(unlatch_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 module "" "" "LINK;EXPORT")
  add_library(${name} MODULE ${module_UNPARSED_ARGUMENTS})
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${UNLATCH_MODULES})
  target_link_libraries(${name} PRIVATE ${module_LINK} unlatch_options)
  set(script ${CMAKE_CURRENT_BINARY_DIR}/${name}.map)
  list(JOIN module_EXPORT "; " names)
  file(CONFIGURE OUTPUT ${script} CONTENT "{ global: ${names}; local: *; };\n")
  target_link_options(${name} PRIVATE -Wl,--version-script=${script} -Wl,--as-needed)
  set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS ${script})
  install(TARGETS ${name} LIBRARY DESTINATION ${UNLATCH_MODULES} COMPONENT tools)
endfunction()
