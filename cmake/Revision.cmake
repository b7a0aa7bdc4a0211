# cmake -DSOURCE=DIR -DOUTPUT=FILE -P Revision.cmake writes which commit is being built; run at every build, it touches
# the file only when something changed. Without git, or outside a clone, the commit is "unknown".
cmake_minimum_required(VERSION 3.25)

set(commit unknown)
set(modified 0)
find_package(Git QUIET)
if(GIT_FOUND AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse HEAD WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE head OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  if(NOT failed)
    set(commit ${head})
    execute_process(COMMAND ${GIT_EXECUTABLE} status --porcelain --untracked-files=no WORKING_DIRECTORY ${SOURCE}
                    OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
      set(modified 1)
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once
#define MSS_COMMIT \"@commit@\"
#define MSS_MODIFIED @modified@
" @ONLY)
