# cmake -DSOURCE=FOLDER -DOUT=FILE -P commit.cmake: the commit of the checkout as a header; -modified if files differ from it,
# "unknown" where there is none.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty=-modified --abbrev=12 --exclude=* OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
  ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit unknown)
endif()
file(WRITE ${OUT} "#pragma once\n#define UNLATCH_COMMIT \"${commit}\"\n")
