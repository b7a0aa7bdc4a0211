# mss_kernel_copies(TARGET NAME [PRECISIONS float double]): compiles NAME_isa.cpp into a target once per instruction set
# of x86-64, and per precision if any are named; core/kernels/dispatch.hpp chooses among the copies at run time. On other
# processors all are the first.
set(mss_flags_of_baseline -ffp-contract=fast -fno-math-errno)
set(mss_flags_of_v3 -ffp-contract=fast -fno-math-errno)
set(mss_flags_of_v4 -ffp-contract=fast -fno-math-errno)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(PREPEND mss_flags_of_v3 -march=x86-64-v3)
  list(PREPEND mss_flags_of_v4 -march=x86-64-v4 -mprefer-vector-width=512)
endif()
# As results say them.
set(flags "")
foreach(set baseline v3 v4)
  string(JOIN " " of_set ${mss_flags_of_${set}})
  list(APPEND flags "${set}: ${of_set}")
endforeach()
set_property(GLOBAL PROPERTY MSS_KERNEL_FLAGS ${flags})

function(mss_kernel_copies target name)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" PRECISIONS)
  if(NOT arg_PRECISIONS)
    set(arg_PRECISIONS double)
  endif()
  string(MAKE_C_IDENTIFIER ${name} id)
  foreach(set baseline v3 v4)
    foreach(real ${arg_PRECISIONS})
      set(copy ${target}_${id}_${set}_${real})
      add_library(${copy} OBJECT ${name}_isa.cpp)
      # Not by linking: the flags of a target that is linked come last, and would turn contraction off again.
      target_include_directories(${copy} PRIVATE $<TARGET_PROPERTY:mss_options,INTERFACE_INCLUDE_DIRECTORIES>)
      target_compile_definitions(${copy} PRIVATE $<TARGET_PROPERTY:mss_options,INTERFACE_COMPILE_DEFINITIONS>)
      target_compile_options(${copy} PRIVATE $<TARGET_PROPERTY:mss_options,INTERFACE_COMPILE_OPTIONS>
                                             ${mss_flags_of_${set}})
      set(isa_name baseline)
      if(NOT set STREQUAL baseline)
        set(isa_name x86-64-${set})
      endif()
      target_compile_definitions(${copy} PRIVATE MSS_ISA=isa_${set} MSS_INSTRUCTION_SET=${set} MSS_ISA_NAME="${isa_name}"
                                                 MSS_REAL=${real})
      set_target_properties(${copy} PROPERTIES UNITY_BUILD OFF)
      target_sources(${target} PRIVATE $<TARGET_OBJECTS:${copy}>)
    endforeach()
  endforeach()
endfunction()
