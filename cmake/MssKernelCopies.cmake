# mss_kernel_copies(TARGET NAME...): adds NAME_baseline.cpp, NAME_v3.cpp and NAME_v4.cpp, copies of some loops
# for three instruction sets of x86-64; NAME.cpp chooses at run time (core/kernels/instruction_sets.hpp), so that the
# binary needs no -march=native. On other processors all three are the first.
function(mss_kernel_copies target)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(options_v3 -march=x86-64-v3)
    set(options_v4 -march=x86-64-v4 -mprefer-vector-width=512)
  endif()
  foreach(name ${ARGN})
    foreach(copy baseline v3 v4)
      target_sources(${target} PRIVATE ${name}_${copy}.cpp)
      set(options ${options_${copy}} -ffp-contract=fast)
      set_source_files_properties(${name}_${copy}.cpp PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON)
    endforeach()
  endforeach()
endfunction()
