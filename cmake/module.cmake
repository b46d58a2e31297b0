# Modules: shared libraries that a program loads when it first needs them (hil/modules/module.h). They lie beside the
# programs in the same way in the build folder and where they are installed.
set(UNLATCH_MODULES ${CMAKE_INSTALL_LIBDIR}/unlatch)

# unlatch_add_module(NAME SOURCE... LINK LIBRARY...): the module libNAME.so.
function(unlatch_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 module "" "" "LINK")
  add_library(${name} MODULE ${module_UNPARSED_ARGUMENTS})
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${UNLATCH_MODULES})
  target_link_libraries(${name} PRIVATE ${module_LINK} unlatch_options)
  # Of the static libraries in it nothing is exported.
  target_link_options(${name} PRIVATE -Wl,--exclude-libs,ALL -Wl,-Bsymbolic -Wl,--as-needed)
  install(TARGETS ${name} LIBRARY DESTINATION ${UNLATCH_MODULES} COMPONENT tools)
endfunction()
