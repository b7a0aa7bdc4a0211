# mss_test_suites(TARGET [FILTER F] [LABELS L...] [ENVIRONMENT E...] [FIRST SUITE...]): one test of CTest per suite of a
# program of GoogleTest, so that its start and CTest's own work are paid once a suite and not once a test. They are listed
# after the program is linked. Those in FIRST take longest: CTest starts them first, so that none is left over at the end.
# A test that is skipped passes with its suite.
function(mss_test_suites target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FILTER" "LABELS;ENVIRONMENT;FIRST")
  if(NOT arg_FILTER)
    set(arg_FILTER *)
  endif()
  get_property(count TARGET ${target} PROPERTY mss_suite_lists)
  math(EXPR count "${count} + 1")
  set_property(TARGET ${target} PROPERTY mss_suite_lists ${count})
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites_${count}.cmake)
  add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS ${list} VERBATIM
    COMMAND ${CMAKE_COMMAND} -D "PROGRAM=$<TARGET_FILE:${target}>" -D "FILTER=${arg_FILTER}" -D "LABELS=${arg_LABELS}"
            -D "ENVIRONMENT=${arg_ENVIRONMENT}" -D "FIRST=${arg_FIRST}" -D "LIST=${list}"
            -P ${PROJECT_SOURCE_DIR}/cmake/ListTestSuites.cmake)
  file(WRITE ${list}.in.cmake "if(EXISTS \"${list}\")
  include(\"${list}\")
else()
  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)
endif()
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${list}.in.cmake)
endfunction()
