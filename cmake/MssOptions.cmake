# Options every target of the project shares. Nothing here relaxes floating point: no -ffast-math anywhere, and
# contraction to fused multiply-adds only in kernels that are compiled per instruction set (MssKernelCopies.cmake).
add_library(mss_options INTERFACE)
target_include_directories(mss_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(mss_options INTERFACE -Wall -Wextra -Wpedantic -Wnon-virtual-dtor -Woverloaded-virtual
                                             -ffp-contract=off -fno-semantic-interposition)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # half a gigabyte before it collects garbage: a tenth of the time to compile
  target_compile_options(mss_options INTERFACE --param=ggc-min-heapsize=524288 --param=ggc-min-expand=1000)
endif()
if(NOT CMAKE_UNITY_BUILD)  # joint sources see each other's names,
  target_compile_options(mss_options INTERFACE -Wshadow)
elseif(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # and are headers to the compiler
  target_compile_options(mss_options INTERFACE -Wno-subobject-linkage)
endif()
# The law of springs, of core/forces/spring_laws/.
if(NOT EXISTS ${PROJECT_SOURCE_DIR}/core/forces/spring_laws/${MSS_SPRING_LAW}.hpp)
  file(GLOB laws RELATIVE ${PROJECT_SOURCE_DIR}/core/forces/spring_laws ${PROJECT_SOURCE_DIR}/core/forces/spring_laws/*.hpp)
  list(TRANSFORM laws REPLACE "\\.hpp$" "")
  list(JOIN laws ", " laws)
  message(FATAL_ERROR "MSS_SPRING_LAW = ${MSS_SPRING_LAW} is no file of core/forces/spring_laws/; give one of ${laws}")
endif()
target_compile_definitions(mss_options INTERFACE MSS_SPRING_LAW_FILE="core/forces/spring_laws/${MSS_SPRING_LAW}.hpp")
# Threads are the ThreadTeam's; Eigen's own would start behind its back wherever OpenMP is on.
target_compile_definitions(mss_options INTERFACE EIGEN_DONT_PARALLELIZE)
if(MSS_WARNINGS_AS_ERRORS)
  target_compile_options(mss_options INTERFACE -Werror)
endif()
if(MSS_SANITIZE)
  target_compile_options(mss_options INTERFACE -fsanitize=${MSS_SANITIZE} -fno-omit-frame-pointer
                                               -fno-sanitize-recover=all
                                               $<$<CXX_COMPILER_ID:Clang>:-Wno-pass-failed>)  # vectorised loops
  target_link_options(mss_options INTERFACE -fsanitize=${MSS_SANITIZE})
  target_compile_definitions(mss_options INTERFACE MSS_SANITIZED=1)
else()
  target_compile_definitions(mss_options INTERFACE MSS_SANITIZED=0)
endif()
